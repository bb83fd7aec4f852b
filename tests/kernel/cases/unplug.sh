# limit: 480
# Unplugging in the middle of a stream, plugging in again, and what is left behind.
. "$QUILTD_SOURCE/tests/kernel/lib.sh"
panel=$QUILTD_BUILD/tests/kernel/panel
no_hid_node() { [ -z "$(hid_node)" ]; }

streaming() { sim_tell counters; [ "$(sed -n 's/^lit=.* rects=\([0-9]*\).*/\1/p' sim.log | tail -n 1)" -gt "${1:-3}" ]; }
told() { # exit status of the stream must be "unplugged"
    local code
    wait "$stream"
    code=$?
    [ "$code" -eq 3 ] || { echo "exit status $code, expected 3"; cat stream.log; }
}
begin_stream() {
    "$panel" draw 512x512 5 0 endless.png > stream.log 2>&1 &
    stream=$!
}
cycle() { # unplug while it streams, replug, stream again
    local before after
    begin_stream
    within 60 streaming || { echo "no rectangle came"; cat stream.log; }
    sim_tell unplug
    told
    within 60 no_hid_node || echo "hidraw stays"
    before=$EPOCHREALTIME
    sim_tell replug
    within 60 granted hid usb
    begin_stream
    within 60 streaming 0 || { echo "no rectangle came again"; cat stream.log; }
    after=$EPOCHREALTIME
    echo "  streaming again after $(awk -v a="$before" -v b="$after" 'BEGIN { printf "%.2f", b - a }') s" >&4
    kill "$stream"
    wait "$stream" 2> /dev/null
}
held() { find "/proc/$sim_pid/fd" -type l 2> /dev/null | wc -l; }
leaks() {
    local before
    before=$(held)
    for _ in 1 2 3 4 5; do
        sim_tell unplug
        sim_tell replug
        within 60 granted hid usb
    done
    [ "$(held)" -eq "$before" ] || echo "descriptors: $before before, $(held) after"
    [ "$(grep -c ' 006 ' /sys/devices/platform/vhci_hcd.0/status)" -eq 1 ] || cat /sys/devices/platform/vhci_hcd.0/status
}

exec 4>&1
fact "vhci_hcd is there" succeeds modprobe vhci_hcd
fact "the panel is plugged in" sim_start --attach --size 512x512 --panel-png shown.png
within 60 granted hid usb
fact "a stream is told of unplugging, and goes on after replugging" cycle
fact "and once more" cycle
fact "replugging leaves nothing behind" leaks
sim_stop
fact "the panel is gone with its simulator" succeeds within 60 no_hid_node
fact "a panel that unplugs itself" sim_start --attach --size 512x512 --unplug-after 20
within 60 granted hid usb
begin_stream
fact "is told as unplugged" told
sim_stop
finish

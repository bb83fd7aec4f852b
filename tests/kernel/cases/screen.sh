# qemu: -device virtio-gpu-pci,xres=1280,yres=800
# The host sees what a display of the guest shows, value by value: what cases about KMS rest on.
. "$QUILTD_SOURCE/tests/kernel/lib.sh"

connector() { modetest -M virtio_gpu -c | awk '$3 == "connected" { print $1; exit }'; }
shows_bars() {
    sleep 30 | modetest -M virtio_gpu -s "$(connector):1280x800" -F smpte > modetest.log 2>&1 &
    within 60 test -s modetest.log || echo "modetest says nothing" # it complains of gamma once the mode is set
    sleep 1
    screendump bars
    head -c 15 "$RESULTS/bars.ppm" | tr '\n' ' ' | grep -q '^P6 1280 800 255' || echo "no picture of 1280x800"
    # the first two of seven bars, grey and yellow
    values 0 0 192 192 192
    values 200 0 192 192 0
}
values() { # x, y, red, green, blue
    local seen
    seen=$(od -An -tu1 -j $((16 + ($2 * 1280 + $1) * 3)) -N 3 "$RESULTS/bars.ppm" | xargs)
    [ "$seen" = "$3 $4 $5" ] || echo "at $1,$2: $seen, expected $3 $4 $5"
}

fact "virtio_gpu is there" succeeds modprobe virtio_gpu
fact "a display is connected" succeeds within 60 test -n "$(connector)"
fact "its picture is what was drawn" shows_bars
finish

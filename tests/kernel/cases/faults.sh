# limit: 480
# Displays that stall, fail, hang, are slow or lie, through the kernel.
. "$QUILTD_SOURCE/tests/kernel/lib.sh"
panel=$QUILTD_BUILD/tests/kernel/panel
with() { # options of quiltsim
    sim_start --attach --no-hid --size 320x200 --panel-png shown.png "$@"
    within 60 granted usb || echo "not there"
}
draws() { # rectangles
    "$panel" draw 320x200 11 "$1" expected.png 2> drawn || { echo "exit status $?"; cat drawn; }
    sim_tell picture
    "$panel" same expected.png shown.png
    echo "  $(tail -n 1 drawn)" >&4
}
refused() { # the host must complain in one line and end by itself
    local words code
    words=$(timeout 30 "$panel" draw 320x200 11 1 expected.png 2> /dev/null)
    code=$?
    [ "$code" -eq 1 ] && [ "$(printf '%s\n' "$words" | wc -l)" -eq 1 ] || echo "exit status $code: $words"
    echo "  $words" >&4
}

exec 4>&1
fact "vhci_hcd is there" succeeds modprobe vhci_hcd
for options in "--stall-every 7" "--fail-every 9" "--hang-every 15" "--bytes-per-second 1000000"; do
    with $options
    fact "a display with $options shows what was drawn" draws 40
    sim_stop
done
for lie in wrong-magic no-formats mode-0x0 tiny-buffer; do
    with --fault "$lie"
    fact "a display that lies with $lie is refused" refused
    sim_stop
done
finish

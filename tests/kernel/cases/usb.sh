# limit: 480
# A simulated panel through the kernel: nodes and their permissions, EEPROM and buttons through hidapi, pixels through libusb.
. "$QUILTD_SOURCE/tests/kernel/lib.sh"
panel=$QUILTD_BUILD/tests/kernel/panel

calibration() { # where to
    cat > "$1" << 'END'
{"configVersion":"1.0","serial":"LKG-2K-04409","pitch":{"value":47.56401443481445},"slope":{"value":-5.480000019073486},
"center":{"value":0.374184787273407},"viewCone":{"value":40.0},"invView":{"value":1.0},"verticalAngle":{"value":0.0},"DPI":{"value":338.0},
"screenW":{"value":2560.0},"screenH":{"value":1600.0},"flipImageX":{"value":0.0},"flipImageY":{"value":0.0},"flipSubp":{"value":0.0}}
END
}
belongs() { # node
    [ "$(owner "$1")" = "root quiltd 660" ] || echo "$1: $(owner "$1"), expected root quiltd 660"
    udevadm info "$1" | grep -q 'TAGS=.*:uaccess:' || echo "$1: no tag uaccess"
}
draws() { # size, rectangles
    "$panel" draw "$1" 7 "$2" expected.png 2> drawn || { echo "exit status $?"; cat drawn; }
    sim_tell picture
    "$panel" same expected.png shown.png
    [ -n "$(tail -n 1 drawn)" ] && echo "  $2 rectangles: $(tail -n 1 drawn)" >&4
}
healthy() {
    sim_tell counters
    grep -E '^lit=' sim.log | tail -n 1 | grep -q 'refused=0 violations=0' || grep -E '^lit=' sim.log | tail -n 1
}

exec 4>&1
calibration given.json
fact "vhci_hcd is there" succeeds modprobe vhci_hcd
fact "the panel is plugged in" sim_start --attach --calibration given.json --size 1536x2048 --panel-png shown.png
fact "hidraw and USB nodes appear, with the rule's rights" succeeds within 60 granted hid usb
ls -l $(hid_node) $(usb_node)
fact "the hidraw node belongs to the group quiltd" belongs "$(hid_node)"
fact "the USB node belongs to the group quiltd" belongs "$(usb_node)"
fact "the calibration is read through hidapi" "$panel" eeprom given.json
fact "buttons arrive in order" presses left right circle square
fact "1000 rectangles are shown as they were drawn" draws 1536x2048 1000
fact "nothing was asked that the protocols do not know" healthy
sim_stop
fact "with LZ4 and a buffer of 256 KiB" sim_start --attach --size 1440x2560 --lz4 --buffer 262144 --panel-png shown.png
fact "the nodes come back" succeeds within 60 granted hid usb
fact "100 rectangles are shown in compressed bands" draws 1440x2560 100
fact "nothing was asked in vain" healthy
sim_stop
for format in rgb565 xrgb8888; do
    fact "a display of $format" sim_start --attach --size 512x512 --formats "$format" --panel-png shown.png
    within 60 granted usb
    fact "takes rectangles" succeeds "$panel" draw 512x512 3 20 expected.png
    sim_stop
done
for file in "$QUILTD_SHARED"/calibration/*.json; do
    [ -e "$file" ] || continue
    sim_start --attach --no-display --calibration "$file"
    within 60 granted hid
    fact "the EEPROM of ${file##*/} is read" "$panel" eeprom "$file"
    sim_stop
done
finish

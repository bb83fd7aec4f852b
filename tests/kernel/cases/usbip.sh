# The line that quiltsim prints plugs the panel in, over TCP; usbip detaches it.
. "$QUILTD_SOURCE/tests/kernel/lib.sh"
panel=$QUILTD_BUILD/tests/kernel/panel

lists() { usbip list -r 127.0.0.1 2>&1 | grep -q '04d8:ef7e' || usbip list -r 127.0.0.1; }
printed_line() { sh -c "$(sed -n 's/^as root: //p' sim.log)" 2>&1; }
detaches() { usbip detach -p 00 > detach.log 2>&1 || cat detach.log; }
gone() { [ -z "$(hid_node)" ]; }

fact "quiltsim listens" sim_start --size 320x200 --panel-png shown.png
fact "usbip lists it" lists
fact "the printed line plugs it in" printed_line
fact "its nodes belong to the group quiltd" succeeds within 60 granted hid usb
usbip port
fact "a button arrives" presses circle
fact "rectangles are drawn" succeeds "$panel" draw 320x200 2 20 expected.png
sim_tell picture
fact "they are shown as they were drawn" "$panel" same expected.png shown.png
fact "usbip detaches it" detaches
fact "its nodes are gone" succeeds within 60 gone
fact "and it can be plugged in again" printed_line
fact "as before" succeeds within 60 granted hid usb
sim_stop
finish

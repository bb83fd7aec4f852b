# The drm device on a real kernel: virtio-gpu as a Portrait, compared with what QEMU shows pixel for pixel, and the console afterwards.
# limit: 600
# memory: 1G
# qemu: -device virtio-gpu-pci,xres=1536,yres=2048,max_hostmem=256M
. "$QUILTD_SOURCE/tests/kernel/lib.sh"
. "$QUILTD_SOURCE/tests/kernel/show.sh"
SIZE=1536x2048

same() { cmp "$RESULTS/$1.ppm" "$RESULTS/$2.ppm"; }
differs() { ! cmp -s "$RESULTS/$1.ppm" "$RESULTS/$2.ppm" || echo "$1 and $2 are equal"; }
console() { # name: a picture of it that is the first one
    screendump "$1"
    within 60 same "$1" console || same "$1" console
}
refuses() { # words, spec, size
    local log
    log=$("$QUILTD_BUILD/tests/kernel/drm_show" "$2" "$3" 2>&1 < /dev/null)
    grep -q "$1" <<< "$log" || echo "$log"
}
unplugged() {
    echo off > "$connector/status"
    echo change > "/sys/class/drm/$card/uevent"
    within 60 grep -q '^gone' show.log || cat show.log
    echo detect > "$connector/status"
}

# The monitor calls itself a Looking Glass from now on; the name has the old one's length and sum, so that the checksum holds.
rename_monitor() {
    LC_ALL=C sed 's/QEMU Monitor/LKG-P00671st/' "$connector/edid" > edid
    [ -s edid ] || echo "the monitor has no EDID"
    cat edid > "/sys/kernel/debug/dri/${card#card}/Virtual-1/edid_override" || echo "the kernel takes no other EDID"
}

modprobe virtio-gpu
within 60 test -e /dev/dri/card0
mount -t debugfs debugfs /sys/kernel/debug 2> /dev/null
connector=$(echo /sys/class/drm/card*-Virtual-1)
card=$(basename "${connector%-Virtual-1}")
printf '\033[2J\033[H\033[?25lthis is the console\n' > /dev/tty1
sleep 1
screendump console

fact "without a Looking Glass the monitors are told" refuses 'no Looking Glass.*Virtual-1 (QEMU Monitor)' drm $SIZE
fact "a calibration for another size is refused with both sizes" refuses '1536x2048.*1440x2560' drm:Virtual-1 1440x2560
fact "an output that is not there is no device" refuses 'LF_E_NODEV' drm:HDMI-A-7 $SIZE
fact "the console is as it was" console still
show_start "drm:$card/Virtual-1" $SIZE 100
fact "frames and 100 pushes of rectangles are taken" shown
fact "a second program is told who has the display" refuses 'LF_E_BUSY.*drm_show (process [0-9]*).*window' drm:Virtual-1 $SIZE
fact "the display shows the frame pixel for pixel" pictured picture
fact "the picture is not the console" differs picture console
show_end
fact "the program ends" ended_well
cat show.log
fact "the console comes back" console after
show_start drm:Virtual-1 $SIZE 1
fact "it shows again" shown
show_kill
show_end 2> /dev/null
fact "the console comes back after kill -9" console killed
fact "the monitor is renamed" rename_monitor
show_start drm $SIZE 3
fact "a Looking Glass is found by its EDID" shown
fact "and shows the frame too" pictured named
show_end
fact "by that name" grep -q '^shown: drm:card0/Virtual-1, LKG-P00671st' show.log
show_start auto $SIZE 1
fact "auto takes it" shown
show_end
show_start drm:Virtual-1 $SIZE 1
fact "after a crash it shows again" shown
fact "taking the monitor away is told" unplugged
show_end
fact "the program ends without the monitor" ended_well
show_start drm:Virtual-1 $SIZE 3
fact "the monitor is back" shown
fact "and shows the frame" pictured again
show_end
fact "that program ends" ended_well
rm -f "$RESULTS"/*.ppm
finish

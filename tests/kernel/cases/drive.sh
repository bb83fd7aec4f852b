# init: systemd
# memory: 2G
# limit: 900
# A machine without a desktop: the drive that a panel keeps its calibration on is mounted by udisks2 for the service, by quiltd's polkit
# rule, seen from within its sandbox, and left as it was. Drives that are no panel's are not.
. "$QUILTD_SOURCE/tests/kernel/lib.sh"
. "$QUILTD_SOURCE/tests/kernel/drive.sh"
rule=/usr/share/polkit-1/rules.d/60-quiltd.rules

settings() {
    printf '%s\n' QUILTD_SCENE=/usr/share/quiltd/scenes/spheres.json \
        'QUILTD_OPTIONS="--views 4 --view-size 60x80 --target-error 0.1"' > /etc/default/quiltd # rendering ends: polkit needs the processor
    printf '%s' '{"configVersion":"3.0","serial":"LKG-PORT-","pitch":52,"slope":-7,"center":0.5,"DPI":324,"screenW":512,"screenH":512}' > visual.json
    drive_make panel.img LKG-P00671 visual.json
    drive_make stick.img STICK visual.json
    cp panel.img before.img
}
# A process of a user, for whom polkit is asked.
holder() { # user
    setpriv --reuid "$1" --regid "$(id -g "$1")" --clear-groups sleep 3000 &
    within 60 owned "$1" $!
}
owned() { [ "$(stat -c %U "/proc/$2")" = "$1" ]; } # user, process
# What polkit says to it when root asks in udisks2's place.
asks() { # process, action, label, type
    timeout 60 pkcheck --action-id "org.freedesktop.udisks2.$2" --process "$1" --detail id.label "$3" --detail id.type "$4" > pkcheck.log 2>&1
}
may_mount() { asks $ours filesystem-mount LKG-P00671 vfat; }
forgotten() { ! may_mount; }
allowed() { asks "$@" || { echo "refused: $*"; cat pkcheck.log; }; }
refused() {
    asks "$@"
    # 1: not authorized; 2: an administrator's password might help
    case $? in 1 | 2) ;; *) echo "not refused: $*"; cat pkcheck.log ;; esac
}
# Asks udisks2 as the service's user; holds when it mounts the volume.
mounts() { # label
    local node
    node=$(drive_node "$1")
    timeout 60 runuser -u quiltd -- udisksctl mount --no-user-interaction -b "$node" > udisks.log 2>&1 || return
    timeout 60 runuser -u quiltd -- udisksctl unmount -b "$node" >> udisks.log 2>&1
}
mounted() { mounts "$1" || cat udisks.log; }
denied() { # label
    mounts "$1"
    grep -q 'NotAuthorized' udisks.log || cat udisks.log
}
doctor() { timeout 120 runuser -u quiltd -- quiltctl doctor > doctor.log 2>&1; }
# Asked again, twice at most, when the 15 s that udisks2 has are not enough for an emulated machine under load.
doctor_says() { # words
    doctor
    for _ in 1 2; do
        grep -q 'udisks2 cannot mount it: Connection timed out' doctor.log || break
        doctor
    done
    grep -q "$1" doctor.log || cat doctor.log
}
list() { timeout 60 quiltctl device.list > list.log 2>&1; }
calibrated() { list && grep -q '^present.calibration_from *drive, /dev/sd' list.log; } # mounted for reading only
shows_nothing() {
    list
    grep -q '^present.kind *none' list.log || cat list.log
}
shows_calibrated() {
    within 200 calibrated || { cat list.log; journalctl --no-pager -n 20 -u quiltd; }
    grep -E '^present.(spec|calibration_from)' list.log >&4
}
gone() { [ ! -e /dev/disk/by-label/LKG-P00671 ]; }
there() { [ -b "$(drive_node "$1")" ]; } # label
plugged() {
    drive_plug panel.img stick.img
    within 200 there LKG-P00671 || echo "udev knows no LKG-P00671"
    within 200 there STICK || echo "udev knows no STICK"
}
times_mounted() { journalctl --no-pager -q -u udisks2 | grep -c 'Mounted /dev/'; }
was_mounted() { [ "$(times_mounted)" -gt 0 ]; }
rests() { # a drive that is mounted is told by the kernel once more, which must not be taken for another
    local before
    before=$(times_mounted)
    sleep 10
    [ "$before" -eq "$(times_mounted)" ]
}
nothing_mounted() { ! grep -E '^/dev/sd' /proc/mounts; }

exec 4>&1
fact "users are made" succeeds systemd-sysusers
fact "folders are made" succeeds systemd-tmpfiles --create /usr/lib/tmpfiles.d/quiltd.conf
fact "logins are managed, as on a machine that was not made for this" succeeds systemctl start systemd-logind
settings
holder quiltd
ours=$!
holder nobody
other=$!
fact "quiltd may mount a volume of LKG-" allowed $ours filesystem-mount LKG-P00671 vfat
fact "without a seat of its own too" allowed $ours filesystem-mount-other-seat LKG-P00671 vfat
fact "not one of another name" refused $ours filesystem-mount STICK vfat
fact "nor with that name in the middle" refused $ours filesystem-mount-other-seat MY-LKG-1 vfat
fact "nor another file system" refused $ours filesystem-mount-other-seat LKG-P00671 ext4
fact "nor a disk of the system" refused $ours filesystem-mount-system LKG-P00671 vfat
fact "nor may it do more than mount" refused $ours filesystem-unmount-others LKG-P00671 vfat
fact "nor may another user" refused $other filesystem-mount-other-seat LKG-P00671 vfat

fact "the service becomes active" succeeds systemctl start quiltd
fact "vhci_hcd is there" succeeds modprobe vhci_hcd
fact "a display is plugged in that is not the panel's" sim_start --attach --no-hid --size 320x200
within 200 granted usb
fact "drives are plugged in, a panel's and a stick with a copy" plugged
fact "the service has the panel's mounted" succeeds within 200 was_mounted
fact "and is done with it, although it does not fit" succeeds within 200 rests
drive_unplug
fact "both are unplugged" succeeds within 200 gone
sim_stop
fact "a display of the panel's size is plugged in" sim_start --attach --no-hid --size 512x512 --panel-png shown.png
within 200 granted usb
mv $rule 60-quiltd.rules
fact "polkit notices that the rule is gone" succeeds within 200 forgotten
fact "the drives are plugged in again" plugged
fact "udisks2 refuses the panel's to the service's user" denied LKG-P00671
fact "which the doctor tells" doctor_says "FAIL.*polkit"
fact "the service shows nothing yet" shows_nothing
mv 60-quiltd.rules $rule
fact "polkit notices that the rule is back" succeeds within 200 may_mount
drive_unplug
fact "both are unplugged again" succeeds within 200 gone
fact "and plugged in" plugged
fact "the service shows with the panel's calibration" shows_calibrated
fact "nothing stays mounted" succeeds within 200 nothing_mounted
fact "the doctor reads it too" doctor_says "^ok.*calibration /dev/.*LKG-PORT-, 512 x 512"
fact "udisks2 mounts it for the service's user" mounted LKG-P00671
fact "and refuses the stick" denied STICK
fact "nothing was written to the drive" cmp before.img panel.img
fact "the service stops" succeeds systemctl stop quiltd
kill $ours $other
drive_unplug
sim_stop
finish

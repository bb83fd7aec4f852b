# What the cases with drives share: USB drives that this kernel is both sides of (dummy_hcd, a mass storage gadget).
# shellcheck shell=bash
gadget=/sys/kernel/config/usb_gadget/drive
# A FAT volume as a file; with a calibration, or without.
drive_make() { # image, label, calibration or nothing
    truncate -s 64M "$1"
    busybox mkdosfs -n "$2" "$1" > drive.log 2>&1 || cat drive.log
    mkdir -p volume
    mount -o loop "$1" volume || return
    mkdir volume/LKG_calibration
    [ -z "${3:-}" ] || cp "$3" volume/LKG_calibration/visual.json
    umount volume
}
# Plugs in one drive; what it holds is what these files hold.
drive_plug() { # image, another one of a second unit
    modprobe -a dummy_hcd libcomposite usb_f_mass_storage || return
    mountpoint -q /sys/kernel/config || mount -t configfs configfs /sys/kernel/config
    local image unit=0 storage=$gadget/functions/mass_storage.0
    mkdir -p "$storage" "$gadget/configs/c.1"
    echo 0x1d6b > $gadget/idVendor # the Linux Foundation's, for gadgets
    echo 0x0104 > $gadget/idProduct
    for image in "$@"; do
        mkdir -p "$storage/lun.$unit"
        echo 1 > "$storage/lun.$unit/removable"
        realpath "$image" > "$storage/lun.$unit/file"
        unit=$((unit + 1))
    done
    [ -e $gadget/configs/c.1/drive ] || ln -s "$storage" $gadget/configs/c.1/drive
    echo dummy_udc.0 > $gadget/UDC
}
drive_unplug() { echo '' > $gadget/UDC; }
drive_node() { readlink -f "/dev/disk/by-label/$1"; } # label

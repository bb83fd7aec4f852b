quilt_srcs := $(call without_isa,$(call room_files,quilt,*.c))

quilt_srcs := $(call without_isa,$(call module_files,quilt,*.c))

quilt_srcs := $(call without_isa,$(call wild,quilt/*.c))

quilt_srcs := $(call wild,quilt/*.c)

base_srcs := $(call wild,base/*.c)

device_srcs := $(call wild,device/*.c)

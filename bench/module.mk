quiltbench_srcs := $(call wild,bench/*.c)

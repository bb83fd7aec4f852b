# model: simulated hardware, for quiltsim, tests and benchmarks; no part of what is installed but of quiltsim
model_srcs := $(call wild,device/model/*.c)
device_srcs := $(filter-out $(model_srcs),$(call module_files,device,*.c))
libs_quiltsim := $(libraries)

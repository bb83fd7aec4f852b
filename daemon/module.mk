# four programs with a main each; the rest is a library, so that tests can link it
quiltd_srcs := $(call wild,daemon/quiltd.c)
quiltctl_srcs := $(call wild,daemon/quiltctl.c)
quiltrender_srcs := $(call wild,daemon/quiltrender.c)
quiltsim_srcs := $(call wild,daemon/quiltsim.c)
daemon_srcs := $(filter-out $(quiltd_srcs) $(quiltctl_srcs) $(quiltrender_srcs) $(quiltsim_srcs),$(call wild,daemon/*.c))

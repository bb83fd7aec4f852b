# Four programs with a main each. The rest are libraries, so that tests can link them: tools, which the programs share; server,
# which quiltd composes; engine, what it renders with, which quiltrender and quiltbench link without the server.
quiltd_srcs := $(call wild,daemon/tools/quiltd.c)
quiltctl_srcs := $(call wild,daemon/tools/quiltctl.c)
quiltrender_srcs := $(call wild,daemon/tools/quiltrender.c)
libs_quiltrender := $(filter-out model,$(libraries))
quiltsim_srcs := $(call wild,daemon/tools/quiltsim.c)
tools_srcs := $(filter-out $(quiltd_srcs) $(quiltctl_srcs) $(quiltrender_srcs) $(quiltsim_srcs),$(call wild,daemon/tools/*.c))
server_srcs := $(foreach f,server parts show wire,$(call wild,daemon/$(f)/*.c))
engine_srcs := $(foreach f,engine output threads,$(call wild,daemon/$(f)/*.c))

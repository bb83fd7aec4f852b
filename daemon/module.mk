# Eight programs with a main each. The rest are libraries, so that tests can link them: tools, which the programs share; server,
# which quiltd composes; engine, what it renders with, which quiltrender and quiltbench link without the server; web, the gateway.
quiltd_srcs := $(call wild,daemon/tools/quiltd.c)
quiltctl_srcs := $(call wild,daemon/tools/quiltctl.c)
quiltrender_srcs := $(call wild,daemon/tools/quiltrender.c)
libs_quiltrender := $(filter-out model,$(libraries))
quiltsim_srcs := $(call wild,daemon/tools/quiltsim.c)
quiltprint_srcs := $(call wild,daemon/tools/quiltprint.c)
quiltmerge_srcs := $(call wild,daemon/tools/quiltmerge.c)
libs_quiltmerge := $(libs_quiltrender)
quiltfarm_srcs := $(call wild,daemon/tools/quiltfarm.c)
# one file that runs on every node, and can be linked statically (LDFLAGS=-static)
libs_quiltfarm := farm engine base
$(O)/quiltfarm: own_libs := -ljansson -lnettle -lm
farm_srcs := $(call wild,daemon/farm/*.c)
tools_srcs := $(filter-out $(quiltd_srcs) $(quiltctl_srcs) $(quiltrender_srcs) $(quiltsim_srcs) $(quiltprint_srcs) $(quiltmerge_srcs) $(quiltfarm_srcs),$(call wild,daemon/tools/*.c))
server_srcs := $(foreach f,server parts show wire,$(call wild,daemon/$(f)/*.c))
engine_srcs := $(foreach f,engine media output threads,$(call wild,daemon/$(f)/*.c))

# the gateway: it renders nothing, and only it links libraries of HTTP
quiltweb_srcs := $(call wild,daemon/web/quiltweb.c)
web_srcs := $(filter-out $(quiltweb_srcs),$(call wild,daemon/web/*.c))
libs_quiltweb := $(filter-out model papers tools,$(libraries))
link_quiltweb = $(dep_web_libs)

# Its page and the schema of scenes are compiled in without indentation, // lines and /** comments: an array of bytes per file, lf_web_index_html.
generated += gen/web_pages.h
page_files := $(call wild,web/page/*) docs/scene.schema.json
$(O)/gen/web_pages.h: $(addprefix $(SRCDIR)/,$(page_files)) $(SRCDIR)/daemon/module.mk
	@mkdir -p $(@D)
	@{ echo '/* made from web/page/ and docs/scene.schema.json */'; for f in $(page_files); do \
	 echo "static const unsigned char lf_web_$$(basename $$f | tr . _)[] = {"; \
	 sed '/^ *\/\/ /d; /^ *\/\*\*.*\*\/$$/d; /^ *\/\*\*/,/\*\/$$/d; s/^ *//' $(SRCDIR)/$$f | od -An -v -tx1 | sed 's/ *\([0-9a-f][0-9a-f]\)/0x\1,/g'; echo '};'; done; } > $@
$(O)/daemon/web/pages.c.o: | $(O)/gen/web_pages.h

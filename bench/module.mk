quiltbench_srcs := $(call wild,bench/*.c)
# what the tests of its parts link
bench_srcs := bench/statistics.c bench/eyes.c

# beside other renderers: ARGS as bench/peers/peers.py --help has them. The scene lies as far from scenes/ here as in the sources.
peers_out := $(BUILDROOT)/bench/peers
$(peers_out)/%.json: $(SRCDIR)/bench/peers/%.json
	@mkdir -p $(@D) && cp $< $@
.PHONY: bench-peers-now
bench-peers-now: all $(peers_out)/cloud_mesh.json
	@$(SRCDIR)/bench/peers/peers.py --build $(O) --out $(peers_out) $(ARGS) $(BUILDROOT)/scenes/cloud.json $(peers_out)/cloud_mesh.json
libs_quiltbench := engine papers render quilt model device base

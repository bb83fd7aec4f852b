# The shipped scenes: their data is made here, by generators that do not depend on the variant being built, and the scene files
# are copied beside it, so that relative paths hold. scenes/bench holds those of `quiltbench table` and
# two of `quiltbench shown`; tests/bench/test_scenes.c knows the hashes of all that they are made of.
scene_generated := scenes/cloud.vdb scenes/fire.vdb scenes/knot.obj scenes/sky.hdr scenes/still.glb scenes/bench/checker.png scenes/tree.ply scenes/forest.npy
scene_data += $(scene_generated) $(call wild,scenes/*.json) $(call wild,scenes/bench/*.json)

$(BUILDROOT)/tools/%: $(SRCDIR)/scenes/%.c
	@mkdir -p $(@D)
	$(call say,CC )$(CC) -std=c11 -O2 -ffp-contract=off -o $@ $< -lm
$(BUILDROOT)/tools/%: $(SRCDIR)/scenes/%.cc
	@mkdir -p $(@D)
	$(call say,CXX)$(CXX) -std=c++17 $(or $(opt_$*),-O1) -ffp-contract=off $(dep_cflags) -o $@ $< -Wl,--as-needed $(dep_openvdb_libs) $(dep_libs)

# what OpenVDB is made of takes half a minute to optimise, and this runs for a tenth of a second
opt_make_test_vdb := -O0

define scene_file
$(BUILDROOT)/scenes/$(1): $(BUILDROOT)/tools/$(2)
	@mkdir -p $$(@D)
	$$(call say,GEN)$$< $$@.new $(3) && mv $$@.new $$@
endef
$(eval $(call scene_file,cloud.vdb,make_vdb,cloud))
$(eval $(call scene_file,fire.vdb,make_vdb,fire))
$(eval $(call scene_file,knot.obj,make_mesh))
$(eval $(call scene_file,sky.hdr,make_sky))
$(eval $(call scene_file,still.glb,make_still))
$(eval $(call scene_file,bench/checker.png,make_still,checker))
$(eval $(call scene_file,tree.ply,make_forest,tree))
$(eval $(call scene_file,forest.npy,make_forest,places 100000))

$(BUILDROOT)/scenes/%.json: $(SRCDIR)/scenes/%.json
	@mkdir -p $(@D)
	@cp $< $@

# what the test of the OpenVDB reader reads
$(O)/testdata/patterns.vdb: $(BUILDROOT)/tools/make_test_vdb
	@rm -rf $(@D).new && mkdir -p $(@D).new
	$(call say,GEN)$< $(@D).new && rm -rf $(@D) && mv $(@D).new $(@D) && touch $@
$(addprefix $(O)/tests/render/,test_vdb_import test_volume_formats_warnings test_import test_mutated_files test_scene test_film_identity test_warnings test_emission_load test_brute_force test_half_space test_frame_file test_units test_shutter test_flow test_albedo_grid test_file_alone test_slice test_skip test_view_blur test_grid_sum test_grid_short test_array_import) $(O)/tests/daemon/test_frames $(O)/tests/daemon/test_quiltbench: | $(O)/testdata/patterns.vdb

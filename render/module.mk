# what reads files from outside is programs of its own: C but where OpenVDB needs C++
quiltimport_srcs := $(reader_srcs) $(filter-out %/vdb_reader.c,$(call wild,render/import/reader/*.c)) render/import/reader/draco_read.cc
quiltimport-vdb_srcs := $(reader_srcs) $(patsubst %,render/import/reader/%,vdb_reader.c vdb_read.cc)
libs_quiltimport := render base
link_quiltimport = $(dep_assimp_libs)
libs_quiltimport-vdb := render base
link_quiltimport-vdb = $(dep_openvdb_libs)
render_srcs := $(filter-out render/import/reader/% render/papers/%,$(call without_isa,$(call module_files,render,*.c)))
# reproductions of papers: for programs that compare with them
papers_srcs := $(call wild,render/papers/*.c)

# the scene schema is compiled in: the parser checks against the very file that the documentation shows
generated += gen/scene_schema.h
$(O)/gen/scene_schema.h: $(wildcard $(SRCDIR)/docs/scene.schema.json)
	@mkdir -p $(@D)
	@{ echo '/* made from docs/scene.schema.json; the bytes of the file and a terminating 0 */'; \
	 echo 'static const unsigned char lf_scene_schema_bytes[] = {'; \
	 cat $^ /dev/null | od -An -v -tx1 | sed 's/ *\([0-9a-f][0-9a-f]\)/0x\1,/g'; echo '0x00};'; } > $@
$(patsubst %,$(O)/%.o,$(render_srcs)): | $(O)/gen/scene_schema.h

# What tests of a folder share, a library each.
test_libraries := stat optics kms spoiled pictures faulty meshes scene_files tables gateway wire
# What a module's tests link: its own library and base; the tests of other folders link everything.
test_libs_base := pictures base
test_libs_quilt := optics pictures quilt base
test_libs_device := kms model device base
test_libs_render := $(if $(PORTABLE),,meshes spoiled pictures) stat $(if $(PORTABLE),,scene_files) papers render base
test_libs_stat := stat $(if $(PORTABLE),,scene_files) papers render base
test_libs_bench := bench stat scene_files render quilt device base
test_libs_daemon := faulty spoiled optics pictures scene_files $(libraries)
test_libs_docs := tables $(libraries)
test_libs_web := gateway $(filter-out tools model papers,$(libraries))
test_link_web = $(dep_web_libs)

fuzz_libs_scene := render base
fuzz_libs_parcel := render base
fuzz_libs_render := render base
fuzz_libs_rpc := $(filter-out tools model,$(libraries))
fuzz_libs_quilt_name := quilt base
fuzz_libs_icc := quilt base
fuzz_libs_profile := quilt base
fuzz_libs_print_file := quilt base
fuzz_libs_pdf := quilt base
fuzz_libs_probe := engine quilt base
fuzz_libs_mesh := meshes render base
fuzz_libs_mesh_arrays := $(fuzz_libs_mesh)
fuzz_libs_gltf := meshes render base
fuzz_libs_instances := meshes render base
fuzz_libs_http := web wire quilt base
fuzz_libs_gateway := web wire quilt base
fuzz_libs_ws := web base
fuzz_libs_cbor := web base
fuzz_libs_nng := web wire quilt base
$(foreach t,http gateway ws cbor nng,$(eval wrap_fuzz_$(t) = $$(dep_web_libs)))
# a reader of the target's own
wrap_fuzz_parcel := -Wl,--wrap=lf_import_run

# Sources with mistakes that its tests switch on, built a second time for them (lf_fault in render/rows/visit.h).
test_faults_render := render/transport/light/emitters.c render/transport/path/path.c $(patsubst %,render/rows/%.c,unscattered vpt extinction_chromatic extinction_grey \
 equiangular_visit light_connect light_paths mvpt prefix_factor visit visit_cut)

# what statistical tests share
stat_srcs := $(filter-out tests/stat/test_%,$(call wild,tests/stat/*.c))

# Loops of tests that take as long as those of the house.
ifeq ($(BUILD),release)
$(foreach f,$(patsubst %.c,%,$(stat_srcs) $(call wild,tests/render/test_suffix*.c) tests/quilt/photographed.c),$(eval isa_$(f) := -O2))
endif

# a reader of the test's own, which gives up the same rights
own_readers := $(addprefix render/,test_import test_import_group test_import_shares)
$(addprefix $(O)/tests/,$(own_readers)): $(O)/base/sandbox/confine.c.o
# Tests that are no part of their folder's program, as those with a wrap_ are not: with objects of their own, or who are asked for the
# files of a mesh.
alone_tests := $(own_readers) $(addprefix render/,test_obj_read $(patsubst %,test_gltf_%,extensions formats material pointer pointer_frames \
 pointer_told read))

# what tests of the print share
optics_srcs := $(filter-out tests/quilt/test_%,$(call wild,tests/quilt/*.c))

# scenes in files
scene_files_srcs := tests/scene_file.c
# files of pictures, files to spoil
pictures_srcs := tests/base/pictures.c
spoiled_srcs := tests/base/spoiled.c
# readers of meshes, which ask whoever links them for files
meshes_srcs := $(patsubst %,render/import/reader/%.c,input words source_material soup polygon weld mesh_build mesh_same maps ply_header ply_read stl_read obj_read mtl_read arrays_read instances_read) \
 $(call wild,render/import/reader/gltf_*.c) render/import/reader/draco_read.cc

# a kernel with displays
kms_srcs := tests/device/fake_kms.c

# tables of docs/reference, and the program that writes them there (make docs)
tables_srcs := $(call wild,tests/docs/tables*.c)
$(O)/tests/docs/make_tables: $(patsubst %,$(O)/%,tests/docs/make_tables.c.o $(patsubst %,lib%.a,tables $(libraries)))
	$(call link,)

# what the gateway calls of the server
wire_srcs := $(call wild,daemon/wire/*.c)

# a gateway with a quiltd that does not exist
gateway_srcs := tests/web/gateway.c tests/web/false_slideshow.c tests/web/caller.c

# a folder that cannot be read
wrap_test_library_list := -Wl,--wrap=readdir

# connections whose time is over soon
wrap_test_listen := -Wl,--wrap=sd_event_add_time_relative,--wrap=bind

# time that passes when the test says so
wrap_test_web_time := -Wl,--wrap=sd_event_add_time_relative,--wrap=sd_event_source_set_time_relative
wrap_test_web_clients := $(wrap_test_web_time)
wrap_test_bridge_time := $(wrap_test_web_time)
wrap_test_nng := $(wrap_test_web_time)

# clients of all services, whose time passes in the same way
wrap_test_services_hostile = $(wrap_test_web_time)

# devices with random faults in place of libusb and hidapi
faulty_srcs := tests/daemon/faulty.c
wrap_test_faults := $(addprefix -Wl$(comma)--wrap=,lf_usb_list lf_usb_open lf_hid_list lf_hid_open)

# a display that hangs in place of libusb's
wrap_test_stuck_display := -Wl,--wrap=lf_usb_list,--wrap=lf_usb_open

# states that cannot be read now
wrap_test_states := -Wl,--wrap=lf_renderer_restore

# a file system without locks
wrap_test_file_locks := -Wl,--wrap=flock,--wrap=access

# many merges, none of which needs to be on a disk
wrap_test_mutated_states := -Wl,--wrap=fsync

# how often a state is saved
wrap_test_job_state := -Wl,--wrap=lf_job_state_write
# a pass that is stopped on its way into the film
wrap_test_render_job := -Wl,--wrap=lf_film_merge
wrap_test_state_kinds = $(wrap_test_job_state),--wrap=fsync
wrap_test_state_faults = $(wrap_test_state_kinds),--wrap=lf_job_state_check,--wrap=lf_renderer_save

# waiting that takes no time
wrap_test_movie_player := -Wl,--wrap=lf_time_now_ns,--wrap=poll,--wrap=ppoll
wrap_test_movie_failures := $(wrap_test_movie_player)
wrap_test_video_stopped := -Wl,--wrap=poll,--wrap=nanosleep

# a slow disk, saves that come soon
wrap_test_save := -Wl,--wrap=fsync,--wrap=sd_event_add_time_relative

# timers that are due soon
wrap_test_saver := -Wl,--wrap=sd_event_add_time_relative
wrap_test_watch := -Wl,--wrap=sd_event_add_time_relative

# a clock of the test's own
wrap_test_play := -Wl,--wrap=lf_time_now,--wrap=sd_event_source_set_time_relative
wrap_test_playlist := $(wrap_test_play)
wrap_test_playlist_media := $(wrap_test_play)
wrap_test_engine_fade := -Wl,--wrap=lf_time_now

# a display, an EEPROM and a udev of the test's own
wrap_test_auto := $(addprefix -Wl$(comma)--wrap=,lf_usb_list lf_usb_open lf_hid_list lf_hid_open lf_find_touches access \
 $(addprefix sd_device_,monitor_attach_event monitor_start get_action get_subsystem get_devnum get_property_value))

# a panel, its buttons and a list of devices of the test's own
wrap_test_show := $(addprefix -Wl$(comma)--wrap=,lf_device_open lf_device_list lf_find_hid lf_find_all pthread_join \
 lf_buttons_open lf_buttons_destroy lf_buttons_poll_fd lf_buttons_next)

# a file that is replaced once its digest is taken
wrap_test_film_identity := -Wl,--wrap=lf_file_digest

# control groups of the test's own
wrap_test_import_limits := -Wl,--wrap=fopen

# files made as on file systems without O_TMPFILE
wrap_test_file := -Wl,--wrap=open

# what the cases of make check-kernel run in their guest
kernel_srcs := $(call wild,tests/kernel/*.c)
kernel_programs := $(patsubst %.c,$(O)/%,$(kernel_srcs))
kernel_cases := $(patsubst tests/kernel/cases/%.sh,%,$(call wild,tests/kernel/cases/*.sh))
define kernel_program
$(1): $(1).c.o $(patsubst %,$(O)/lib%.a,model device base)
	$$(call link,)
endef
$(foreach p,$(kernel_programs),$(eval $(call kernel_program,$(p))))

# under the unmodified libraries
isa_tests/device/test_hid_umockdev = $(dep_umockdev_cflags)
wrap_test_hid_umockdev = $(dep_umockdev_libs)
isa_tests/device/test_usb_umockdev = $(dep_umockdev_cflags)
wrap_test_usb_umockdev = $(dep_umockdev_libs)

# What needs none of the libraries, with its tests and a program that prints hashes of results: PORTABLE=1 builds nothing else, for
# machines without those libraries (tests/arm64.sh). Embree's header stays: it is the same everywhere.
portable_tests := base/test_alloc base/test_cpu base/test_status base/test_thread quilt/test_interlace quilt/test_tone quilt/test_layout \
 quilt/test_rects quilt/test_fill quilt/test_quilt_kernel render/test_kernel render/test_sampler
ifdef PORTABLE
base_srcs := $(patsubst %,base/%.c,alloc cpu status thread image)
quilt_srcs := $(filter-out quilt/files.c quilt/layout_name.c quilt/print/% quilt/chart/%,$(quilt_srcs))
render_srcs := $(filter render/plane/kernel% render/plane/fan% render/transport/lanes/suffix% render/transport/lanes/depth_% render/transport/surface/surface_fan%,$(render_srcs)) $(patsubst %,render/%.c,plane/slice plane/body scene/volume transport/sampler $(patsubst %,transport/surface/surface_%,sheen glass glass_energy energy))
stat_srcs := tests/stat/stat.c tests/stat/chi2.c
papers_srcs :=
test_faults_render :=
optics_srcs :=
pictures_srcs :=
dep_cflags := -I$(SRCDIR)/tests/arm64 -idirafter /usr/include
dep_libs := -lm
endif
$(O)/tests/arm64/results: $(patsubst %,$(O)/%,tests/arm64/results.c.o librender.a libquilt.a libbase.a)
	$(call link,)
.PHONY: portable portable-tests
portable: $(patsubst %,$(O)/tests/%,$(portable_tests)) $(O)/tests/arm64/results $(patsubst %,$(O)/lib%.a,render quilt base)
portable-tests:
	@echo $(abspath $(patsubst %,$(O)/tests/%,$(portable_tests)))

# What a room's tests link: its own library and base; the tests of other folders link everything.
test_libs_base := base
test_libs_quilt := optics quilt base
test_libs_device := device base
test_libs_render := stat render base
test_libs_stat := stat render base

# what statistical tests share
stat_srcs := $(filter-out tests/stat/test_%,$(call wild,tests/stat/*.c))

# what tests of the print share
optics_srcs := $(filter-out tests/quilt/test_%,$(call wild,tests/quilt/*.c))

# files made as on file systems without O_TMPFILE
wrap_test_file := -Wl,--wrap=open

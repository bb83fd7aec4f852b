# what reads files from outside is programs of its own; these two files are in all of them
reader_srcs := base/sandbox/reader.c base/sandbox/confine.c
quiltimport-picture_srcs := $(reader_srcs) base/sandbox/picture_reader.c
base_srcs := $(filter-out $(quiltimport-picture_srcs),$(call module_files,base,*.c))
libs_quiltimport-picture := base

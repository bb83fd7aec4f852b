base_srcs := $(call wild,base/*.c) $(call wild,base/import/*.c)
# what reads files from outside is programs of its own; these two files are in all of them
reader_srcs := base/reader/reader.c base/reader/confine.c
quiltimport-picture_srcs := $(reader_srcs) base/reader/picture_reader.c
libs_quiltimport-picture := base

# The flags of the house. CC, CXX, CFLAGS, CXXFLAGS, CPPFLAGS, LDFLAGS and LDLIBS belong to the caller and come last.
ifeq ($(origin CC),default)
CC := gcc
endif
ifeq ($(origin CXX),default)
CXX := g++
endif
ARCH := $(shell $(CC) -dumpmachine 2>/dev/null | cut -d- -f1)

lf_warnings := -Wall -Wextra -Wpedantic -Wshadow -Wundef -Wvla -Wdouble-promotion -Wcast-qual -Wwrite-strings -Wpointer-arith \
 -Wformat=2 -Wimplicit-fallthrough
lf_cwarnings := -Wconversion -Wsign-conversion -Wstrict-prototypes -Wmissing-prototypes
# another compiler's words on the same code are of no use here
ifeq ($(BUILD),fuzz)
lf_warnings :=
lf_cwarnings :=
endif
# Clang has other words behind these: the sign of enumerations, INFINITY that becomes a double, fields left out on purpose
ifneq ($(findstring clang,$(shell $(CC) --version 2>/dev/null)),)
lf_warnings := $(filter-out -Wdouble-promotion -Wformat=2,$(lf_warnings)) -Wno-missing-field-initializers -Wno-unknown-pragmas
lf_cwarnings := $(filter-out -Wsign-conversion -Wconversion,$(lf_cwarnings))
endif
ifdef WERROR
lf_warnings += -Werror
endif

# no contraction: the same bits from every instruction set, and NaN and infinity as they are
lf_float := -ffp-contract=off -fno-math-errno -fno-trapping-math

# -g1: lines and names of functions, which is all that a stack shows; variables (-g) take a third of the time of compiling.
# BUILD=debug has them.
variant_release := -O2 -g1 -D_FORTIFY_SOURCE=2 -fstack-protector-strong
variant_debug := -Og -g
variant_asan := -O1 -g1 -fno-omit-frame-pointer -fsanitize=address,undefined -fno-sanitize-recover=all
variant_tsan := -O1 -g1 -fno-omit-frame-pointer -fsanitize=thread
# clang's: make fuzz
variant_fuzz := -O1 -g1 -fno-omit-frame-pointer -fsanitize=address,undefined,fuzzer-no-link -fno-sanitize-recover=all
ifeq ($(variant_$(BUILD)),)
$(error BUILD=$(BUILD): expected release, debug, asan, tsan or fuzz)
endif
# Tests ask more than they compute, but for those of tests/stat and of lanes (tests/module.mk).
ifeq ($(BUILD),release)
opt_render := -O3
opt_quilt := -O3
# renders nothing
opt_render/import := -O2
opt_tests := -O1
endif
# where the time of the sanitizers goes: half of it. Stacks whose variables outlive their function (use after return) make rendering
# twice as slow; the readers of files (render/import) and the rest of the house have them.
ifneq ($(filter asan tsan,$(BUILD)),)
opt_render := -O2 $(if $(filter asan,$(BUILD)),--param=asan-use-after-return=0)
opt_quilt := $(opt_render)
opt_render/import := -O2
endif

lf_common = $(variant_$(BUILD)) $(lf_float) $(lf_warnings) -pthread -I$(SRCDIR) -I$(O)
lf_cflags = -std=c11 -D_GNU_SOURCE -fvisibility=hidden $(lf_common) $(lf_cwarnings) $(dep_cflags)
# not hidden: the statics of OpenVDB's templates must be the library's own, a hidden copy is never initialised
lf_cxxflags = -std=c++17 -D_GNU_SOURCE $(lf_common) $(dep_cflags)
lf_ldflags = $(filter -fsanitize%,$(variant_$(BUILD))) -pthread -Wl,--as-needed -Wl,-z,relro,-z,now

# one file an instruction set; other machines leave them out
x86 := $(filter x86_64,$(ARCH))
arm64 := $(filter aarch64,$(ARCH))
# Below -O2 GCC leaves out vzeroupper, and whatever runs after such a function runs at half its speed, unless this asks for it.
avx := $(if $(filter asan debug,$(BUILD)),-fexpensive-optimizations)
isa_quilt/kernel/kernel_avx2 := -mavx2 $(avx)
isa_render/plane/fan_avx2 := -mavx2 $(avx)
isa_render/plane/kernel_avx2 := -mavx2 -mf16c $(avx)
isa_render/plane/kernel_avx512 := -mavx512f $(avx)
isa_render/reconstruct/kernel_avx2 := -mavx2 $(avx)
isa_render/reconstruct/kernel_avx512 := -mavx512f $(avx)
isa_render/transport/lanes/depth_avx2 := -mavx2 $(avx)
isa_render/transport/lanes/suffix_avx2 := -mavx2 $(avx)
isa_render/transport/lanes/suffix_avx512 := -mavx512f -mprefer-vector-width=512 $(avx)
isa_render/transport/surface/surface_fan_avx2 := -mavx2 $(avx)
isa_render/transport/surface/surface_fan_avx512 := -mavx512f -mprefer-vector-width=512 $(avx)
# OpenVDB's templates, at half the time of -O2: reading a file takes as long, and yields the same bytes
isa_render/import/reader/vdb_read := -O1
# The lanes of suffixes are one template that is compiled three times. With both sanitizers at -O2 each took 70 s and more: -O1 is
# enough, and UndefinedBehaviorSanitizer looks at the C copy alone, to whose bits test_suffix and test_suffix_sky hold the others.
# AddressSanitizer sees all.
ifeq ($(BUILD),asan)
isa_render/transport/lanes/suffix_c := -O1
isa_render/transport/lanes/suffix_avx2 += -O1 -fno-sanitize=undefined
isa_render/transport/lanes/suffix_avx512 += -O1 -fno-sanitize=undefined
endif
# fuzz_render renders: the lanes of suffixes would take minutes to compile with sanitizers, and are not looked at by them
ifeq ($(BUILD),fuzz)
isa_render/transport/lanes/suffix_c := -O0 -fno-sanitize=all
isa_render/transport/lanes/suffix_avx2 += -O0 -fno-sanitize=all
isa_render/transport/lanes/suffix_avx512 += -O0 -fno-sanitize=all
endif
without_isa = $(filter-out $(if $(x86),,%_avx2.c %_avx512.c) $(if $(arm64),,%_neon.c),$(1))

# quiltd: one make process, one graph. Every module has a module.mk that appends to the lists below.
#
#   make                    programs and scenes into build/ (packages must be there: make deps)
#   make run | check        install what is missing, build, and start the daemon | run all tests
#   SCENE=FILE DEVICE=NAME RUN_FOR=SECONDS ARGS="…"   what make run shows, where, how long, and more options of quiltd
#   WEB=1 (or a port)       make run also serves a page for a browser, and prints its URL
#   make install            programs, man pages, completions, scenes, units, udev and polkit rules: PREFIX (/usr/local), DESTDIR
#   make deb                Debian packages into build/deb, a folder that apt can use
#   make check-distro       make run and make check in clean roots of Debian releases: DISTROS='bookworm trixie'; as root
#   make deps | clean       install what building needs | remove what was built
#   make bench | verify     all benchmarks (ARGS='curve FILE': one) | the long tests with fresh seeds
#   make bench-page         times of quiltweb's page in a browser, as medians, on a machine that does nothing else
#   make bench-playlist     a minute of a slideshow: images, their intervals, dropped frames, on a machine that does nothing else
#   make lint               static checks
#   make python             the client in Python: a wheel and an sdist in build/
#   make docs               write the tables of docs/reference from the tables of the programs
#   make fuzz               feed random bytes to the readers: FUZZ_SECONDS each (60); T=hid: only that one
#   make soak               the daemon on a panel with random faults, then the gateway among hostile clients: SOAK_SECONDS each (600), SOAK_SEED
#   make mutants            break one line at a time and list the changes that no test detects; T=render: only those with this word
#   make check-arm64        the portable parts, built for arm64 and run by an emulator
#   make check-kernel       simulated devices through a real kernel and the installed daemon under systemd, in QEMU; as root
#   make check-clients      bridge.js, a WebXR page in a browser, nngcat and the requests of other programs, before quiltweb
#   make T=render check     only the tests whose path holds this word; WITHOUT='tests/render/test_bias …' leaves those out
#   make tests              builds what make check runs, with the same T and WITHOUT
#   make build/release/tests/base/test_file     one test program
#   READERS=build/release   the programs that read files are those that are built there, not built again
#   BUILD=release|debug|asan|tsan  O=DIR  V=1  WERROR=1  CC CXX CFLAGS CXXFLAGS LDFLAGS  DESTDIR PREFIX
#
# Lists that fragments append to (paths relative to the source tree unless said otherwise):
#   <library>_srcs  sources of lib<library>.a       <program>_srcs   sources of a program's own
#   isa_<file>      extra flags of one source file, by its path without the ending
#   opt_<folder>    extra flags of a folder and those in it that have none of their own
#   link_<program>  libraries that it alone needs; test_link_<folder>: that tests of a folder need
#   scene_data      files in $(BUILDROOT) to be made with the programs (rules in the same fragment)
.SUFFIXES:
.DELETE_ON_ERROR:
.SECONDARY:
MAKEFLAGS += --no-builtin-rules

MAKEFILE := $(lastword $(MAKEFILE_LIST))
SRCDIR := $(patsubst %/,%,$(dir $(MAKEFILE)))
BUILD ?= release
O ?= build/$(BUILD)
# what all variants share: flags of the libraries, data of the scenes
BUILDROOT := $(patsubst %/$(BUILD),%,$(O))

PREFIX ?= /usr/local
BINDIR ?= $(PREFIX)/bin
DATADIR ?= $(PREFIX)/share
UNITDIR ?= $(PREFIX)/lib/systemd/system
USERUNITDIR ?= $(PREFIX)/lib/systemd/user
SYSUSERSDIR ?= $(PREFIX)/lib/sysusers.d
TMPFILESDIR ?= $(PREFIX)/lib/tmpfiles.d
UDEVDIR ?= $(PREFIX)/lib/udev/rules.d
# polkit 122 does not read /usr/local
POLKITDIR ?= $(if $(filter /usr/local,$(PREFIX)),/etc,$(DATADIR))/polkit-1/rules.d
INSTALL ?= install

comma := ,
# what reads files for the others: installed beside bin, in libexec
readers := quiltimport quiltimport-vdb quiltimport-picture
programs := quiltd quiltctl quiltrender quiltfarm quiltmerge quiltprint quiltsim quiltbench quiltweb $(readers)
modules := base render quilt device daemon
# each stands before those whose functions it calls
libraries := web tools server farm engine papers render quilt model device base

.PHONY: all FORCE
all:

# Goals that install packages first, then come back here as GOAL-now.
front := check check-arm64 check-clients check-kernel check-distro run bench bench-page bench-playlist verify lint fuzz soak mutants deb
# Goals that need no library flags.
light := $(front) deps clean help python
goals := $(or $(MAKECMDGOALS),all)

# files of one pattern in a module and its folders
module_files = $(foreach d,$(2) */$(2) */*/$(2),$(call wild,$(1)/$(d)))
wild = $(patsubst $(SRCDIR)/%,%,$(sort $(wildcard $(SRCDIR)/$(1))))

include $(SRCDIR)/.ci/flags.mk
include $(wildcard $(SRCDIR)/*/module.mk)
ifneq ($(if $(PORTABLE),,$(filter-out $(light),$(goals))),)
include $(BUILDROOT)/deps.mk
endif

# anew after packages have come or gone: make check wants more of them than make run before it
$(BUILDROOT)/deps.mk: $(SRCDIR)/.ci/deps $(wildcard /var/lib/dpkg/status)
	@mkdir -p $(@D)
	@CC='$(CC)' CXX='$(CXX)' $(SRCDIR)/.ci/deps flags > $@.new
	@mv $@.new $@ && { [ ! -e /var/lib/dpkg/status ] || [ ! $@ -ot /var/lib/dpkg/status ] || touch -r /var/lib/dpkg/status $@; }

# ------------------------------------------------------------------------------------------------------- building --
built := $(addprefix $(O)/,$(foreach p,$(programs),$(if $($(p)_srcs),$(p))))
all: $(built) $(patsubst %,$(O)/lib%.a,$(libraries)) $(addprefix $(BUILDROOT)/,$(scene_data))
objs = $(patsubst %,$(O)/%.o,$(1))
say = $(if $(V),,@echo '  $(1) $(patsubst $(O)/%,%,$@)';)

# build/quiltd and its siblings are those of the release
ifeq ($(O),$(BUILDROOT)/release)
links := $(patsubst $(O)/%,$(BUILDROOT)/%,$(built))
all: $(links)
$(links): $(BUILDROOT)/%: $(O)/%
	@ln -sfn release/$* $@
endif
# built where the sources are, the shipped scenes work where they lie too (not by symbolic links: the daemon would refuse those)
ifeq ($(BUILDROOT),build)
scene_copies := $(addprefix $(SRCDIR)/,$(scene_generated))
all: $(scene_copies)
$(scene_copies): $(SRCDIR)/%: $(BUILDROOT)/%
	@ln -f $< $@ 2>/dev/null || cp -p $< $@
endif

# rewritten only when a compile line changed: a change of flags is a rebuild
$(O)/flags.stamp: FORCE
	@mkdir -p $(@D); printf '%s\n' '$(subst ','\'',$(CC) $(CXX) $(lf_cflags) $(lf_cxxflags) $(foreach v,$(sort $(filter opt_% isa_%,$(.VARIABLES))),$(v)=$($(v))) $(CPPFLAGS) $(CFLAGS) $(CXXFLAGS) $(LDFLAGS))' > $@.new; \
	 if cmp -s $@.new $@; then rm $@.new; else mv $@.new $@; fi
FORCE:

parent_of = $(patsubst %/,%,$(filter-out ./,$(dir $(1))))
opt_of = $(if $(1),$(if $(filter undefined,$(origin opt_$(1))),$(call opt_of,$(call parent_of,$(1))),$(opt_$(1))))
$(O)/%.c.o: $(SRCDIR)/%.c $(O)/flags.stamp
	@mkdir -p $(@D)
	$(call say,CC )$(CC) $(lf_cflags) $(call opt_of,$*) $(isa_$*) $(CPPFLAGS) $(CFLAGS) -MMD -MP -c -o $@ $<
$(O)/faults/%.c.o: $(SRCDIR)/%.c $(O)/flags.stamp
	@mkdir -p $(@D)
	$(call say,CC )$(CC) $(lf_cflags) $(call opt_of,$*) -DLF_FAULTS $(CPPFLAGS) $(CFLAGS) -MMD -MP -c -o $@ $<
$(O)/%.cc.o: $(SRCDIR)/%.cc $(O)/flags.stamp
	@mkdir -p $(@D)
	$(call say,CXX)$(CXX) $(lf_cxxflags) $(call opt_of,$*) $(isa_$*) $(CPPFLAGS) $(CXXFLAGS) -MMD -MP -c -o $@ $<

define library
$(O)/lib$(1).a: $(call objs,$($(1)_srcs))
	@mkdir -p $$(@D)
	$$(call say,AR )rm -f $$@ && $$(AR) rcs $$@ $$^
endef
$(foreach l,$(libraries),$(eval $(call library,$(l))))
libs = $(patsubst %,$(O)/lib%.a,$(1))
link = $(call say,LD )$(CXX) $(lf_ldflags) $(LDFLAGS) -o $@ $(filter %.o %.a,$^) $(or $(own_libs),$(dep_libs)) $(1) $(LDLIBS)

define program
$(O)/$(1): $(call objs,$($(1)_srcs)) $(call libs,$(or $(libs_$(1)),$(filter-out model papers,$(libraries)))) $(if $(filter $(readers),$(1)),$(O)/readers.stamp)
	@rm -f $$@
	$$(call link,$$(link_$(1)))
endef
$(foreach p,$(if $(READERS),$(filter-out $(readers),$(programs)),$(programs)),$(eval $(call program,$(p))))
ifdef READERS
$(addprefix $(O)/,$(readers)): $(O)/%: $(READERS)/% $(O)/readers.stamp
	@ln -sfn $(abspath $<) $@
endif
# whose readers they are: rewritten only when that changes
$(O)/readers.stamp: FORCE
	@mkdir -p $(@D); echo '$(READERS)' > $@.new; if cmp -s $@.new $@; then rm $@.new; else mv $@.new $@; fi

# --------------------------------------------------------------------------------------------------------- testing --
test_srcs := $(call wild,tests/*/test_*.c)
tests := $(patsubst %.c,$(O)/%,$(test_srcs))
headers := $(foreach r,$(modules) tests,$(call module_files,$(r),*.h))
# Every header compiles alone. One that a source begins with has been shown to: the others are compiled by themselves.
c_srcs = $(filter %.c,$(sort $(foreach l,$(libraries) $(test_libraries) $(programs),$($(l)_srcs)) $(test_srcs)))
begun_with := $(if $(filter-out $(light),$(goals)),$(shell cd $(SRCDIR) && awk '/^\#/ { if ($$2 ~ /^"/) print $$2; nextfile }' $(c_srcs) | tr -d '"'))
headers_alone := $(patsubst %,$(O)/alone/%.ok,$(filter-out $(begun_with),$(headers)))
$(foreach l,$(test_libraries) bench,$(eval $(call library,$(l))))
# a hundred programs, linked in a third of the time
test_linker := $(if $(PORTABLE)$(findstring -fuse-ld,$(LDFLAGS)),,$(if $(shell command -v ld.gold),-fuse-ld=gold))
test_objs = $(call objs,$(addprefix faults/,$(test_faults_$(1))))
test_libs = $(call libs,$(or $(test_libs_$(1)),$(libraries)))

matching = $(foreach x,$(1),$(if $(strip $(foreach t,$(T),$(findstring $(t),$(x)))),$(x)))
matching_or_all = $(if $(T),$(call matching,$(1)),$(1))
folder = $(notdir $(patsubst %/,%,$(dir $(1))))

define test
$(O)/$(1:.c=): $(call objs,$(1)) $(call test_objs,$(call folder,$(1))) $(call test_libs,$(call folder,$(1)))
	@rm -f $$@
	$$(call link,$$(dep_test_libs) $$(test_link_$(call folder,$(1))) $$(wrap_$(notdir $(1:.c=))) $$(test_linker))
endef
# The tests of a folder are one program, linked once, with as many names: each runs the test of its name (tests/runner.c). Those that
# change what they link stand alone, and so do single ones that are asked for: the others of their folder need not be built.
in_runner = $(filter-out $(addprefix tests/,$(alone_tests)) $(foreach t,$(1),$(if $(wrap_$(notdir $(t:.c=))),$(t:.c=))) $(WITHOUT),$(1:.c=))
whole = $(if $(PORTABLE)$(filter $(O)/tests/%,$(goals)),,$(if $(T),$(if $(filter-out $(call matching,$(1)),$(1)),,$(1)),$(1)))
$(foreach f,$(sort $(dir $(test_srcs))),$(eval runner_$(f) := $(call whole,$(call in_runner,$(filter $(f)%,$(test_srcs))))))
runners := $(foreach f,$(sort $(dir $(test_srcs))),$(if $(word 2,$(runner_$(f))),$(f)))
run_together := $(foreach f,$(runners),$(runner_$(f)))
define runner
$(O)/$(1)runner.list: FORCE
	@mkdir -p $$(@D); echo '$(patsubst %,LF_TEST(%),$(notdir $(runner_$(1))))' > $$@.new; if cmp -s $$@.new $$@; then rm $$@.new; else mv $$@.new $$@; fi
$(O)/$(1)runner.o: $(SRCDIR)/tests/runner.c $(O)/$(1)runner.list $(O)/flags.stamp
	$$(call say,CC )$$(CC) $$(lf_cflags) $$(CPPFLAGS) $$(CFLAGS) -DLF_TESTS="$$$$(cat $(O)/$(1)runner.list)" -c -o $$@ $$<
$(O)/$(1)runner: $(O)/$(1)runner.o $(patsubst %,$(O)/%.main.o,$(runner_$(1))) $(call test_objs,$(call folder,$(1))) $(call test_libs,$(call folder,$(1)))
	@rm -f $$@
	$$(call link,$$(dep_test_libs) $$(test_link_$(call folder,$(1))) $$(test_linker))
$(addprefix $(O)/,$(runner_$(1))): $(O)/$(1)runner
	@ln -f $$< $$@ 2>/dev/null || cp -p $$< $$@
endef
$(foreach t,$(filter-out $(addsuffix .c,$(run_together)),$(test_srcs)),$(eval $(call test,$(t))))
$(foreach f,$(runners),$(eval $(call runner,$(f))))
OBJCOPY ?= objcopy
$(O)/tests/%.main.o: $(O)/tests/%.c.o
	@$(OBJCOPY) --redefine-sym main=$(notdir $*)_main $< $@
$(if $(PORTABLE),,$(tests): | $(addprefix $(O)/,$(readers)))

# a fuzz target is its one file with the libraries it looks at (fuzz_libs_NAME, where they are others; tests/module.mk)
fuzz_srcs := $(call wild,tests/fuzz/fuzz_*.c)
fuzz_targets := $(patsubst %.c,$(O)/%,$(fuzz_srcs))
fuzz_libs = $(call libs,$(or $(fuzz_libs_$(1:fuzz_%=%)),model device base))
define fuzz_target
$(O)/$(1:.c=): $(call objs,$(1)) $(call fuzz_libs,$(notdir $(1:.c=)))
	$$(call link,-fsanitize=fuzzer $$(wrap_$(notdir $(1:.c=))))
endef
$(foreach f,$(fuzz_srcs),$(eval $(call fuzz_target,$(f))))
# films know nothing of the rest of their module
$(addprefix $(O)/tests/fuzz/fuzz_,film merge): $(call objs,$(call module_files,render/film,*.c))

$(O)/alone/%.h.ok: $(SRCDIR)/%.h $(O)/flags.stamp
	@mkdir -p $(@D)
	$(call say,HDR)printf '#include "%s"\nextern int lf_header_alone;\n' '$*.h' | $(CC) $(lf_cflags) $(CPPFLAGS) $(CFLAGS) -MMD -MP -MT $@ -MF $@.d -fsyntax-only -x c - && touch $@

# MAKE_AGAIN: this make, told the same, so that nothing is built anew
run_tests = O='$(O)' SRCDIR='$(SRCDIR)' BUILD='$(BUILD)' \
 MAKE_AGAIN='$(MAKE_COMMAND) --no-print-directory -C $(CURDIR) -f $(MAKEFILE) O=$(O) BUILD=$(BUILD)' $(SRCDIR)/tests/run

.PHONY: tests fuzz-targets check-now check-arm64-now check-clients-now check-kernel-now verify-now bench-now run-now lint-now fuzz-now soak-now mutants-now
# what renders for long, and what asks nothing of a program, is run once, as it is built for users
tests_extra := $(addprefix $(SRCDIR)/tests/,client.sh python.sh js.sh $(if $(filter release,$(BUILD)),style.sh install.sh completion.sh page_modules.sh farm.sh node.sh readme.sh guides.sh page.sh web_soak.sh arm64.sh))
selected := $(filter-out $(addprefix $(O)/,$(WITHOUT)),$(call matching_or_all,$(tests)))
tests: all $(selected) $(if $(T)$(filter-out release,$(BUILD)),,$(headers_alone)) $(O)/tests/arm64/results
check-now: tests
	@$(run_tests) $(if $(T),$(call matching,$(tests_extra)),$(tests_extra)) $(selected)

check-arm64-now: $(O)/tests/arm64/results
	@$(run_tests) $(SRCDIR)/tests/arm64.sh

# a line per step, then the sum
check-clients-now: all
	@rc=0; TEST_TIMEOUT=$${TEST_TIMEOUT:-1800} $(run_tests) $(SRCDIR)/tests/clients.sh > $(O)/clients.sum || rc=1; \
	 grep -v '^\[  PASSED  \]\|^\[==' $(O)/tests/clients.sh.log; tail -n 1 $(O)/clients.sum; exit $$rc

# T=word: only the cases with that word
check-kernel-now: all $(kernel_programs)
	@KERNEL='$(BUILDROOT)/kernel' $(subst /tests/run,/tests/kernel/run,$(run_tests)) $(call matching_or_all,$(kernel_cases))

# the statistical tests again, on numbers nobody has seen, at their longest
verify-now: all $(tests)
	@seed=$${QUILTD_SEED:-$$(od -An -N4 -tu4 /dev/urandom | tr -d ' ')}; echo "QUILTD_SEED=$$seed"; \
	 QUILTD_SEED=$$seed QUILTD_LONG=1 TEST_TIMEOUT=$${TEST_TIMEOUT:-3600} $(run_tests) $(tests)

# their tables are the last thing in the log; a command that was delayed is a failure here
soak-now: $(O)/tests/daemon/test_faults all
	@seed=$${SOAK_SEED:-$$(od -An -N4 -tu4 /dev/urandom | tr -d ' ')}; seconds=$${SOAK_SECONDS:-600}; rc=0; \
	 export SOAK_SEED=$$seed SOAK_SECONDS=$$seconds SOAK_STRICT=1 TEST_TIMEOUT=$$((seconds + 1200)); \
	 $(run_tests) $< || rc=1; \
	 $(run_tests) $(SRCDIR)/tests/web_soak.sh || rc=1; \
	 sed -n '/^SOAK_SEED/,/^descriptors/p' $(O)/tests/test_faults.log; sed -n '/^#/p' $(O)/tests/web_soak.sh.log; exit $$rc

# in a copy of the tree, which starts with what is built here
mutants-now: all $(tests)
	@O='$(O)' SRCDIR='$(SRCDIR)' MAKE='$(MAKE_COMMAND)' $(SRCDIR)/tests/mutants/run $(T)

fuzz-targets: $(call matching_or_all,$(fuzz_targets))
fuzz-now: fuzz-targets
	@O='$(O)' $(SRCDIR)/tests/fuzz.sh $(call matching_or_all,$(fuzz_targets))

# tables of docs/reference from those of the programs; a test compares them
.PHONY: docs
docs: $(O)/tests/docs/make_tables $(O)/quiltd $(O)/quiltrender
	@cd $(SRCDIR) && $(abspath $<) $(abspath $(O))
	@$(SRCDIR)/clients/js/make_types.sh $(O)/quiltd

bench-now: all
	@mkdir -p $(BUILDROOT)/bench
	$(O)/quiltbench $(if $(ARGS),$(ARGS),--out $(BUILDROOT)/bench)

.PHONY: bench-playlist-now
bench-playlist-now: all
	@O='$(O)' SRCDIR='$(SRCDIR)' $(SRCDIR)/tests/bench_playlist.sh

.PHONY: bench-page-now
bench-page-now: all
	@O='$(O)' SRCDIR='$(SRCDIR)' $(SRCDIR)/tests/page/bench.sh '$(SCENE)'

# --------------------------------------------------------------------------------------------- everyday commands --
self = $(MAKE) --no-print-directory -f $(MAKEFILE)
jobs = $(if $(filter -j% --jobserver%,$(MAKEFLAGS)),,-j$(shell nproc 2>/dev/null || echo 1))
.PHONY: deps $(front) clean help install
deps:
	@$(SRCDIR)/.ci/deps install build test
# Ctrl-C is for quiltd alone: this make would call its end an error
run:
	@$(SRCDIR)/.ci/deps install build
	@$(self) $(jobs) all
	@trap '' INT; $(self) $@-now
bench:
	@$(SRCDIR)/.ci/deps install build bench
	@$(self) $(jobs) $@-now
bench-playlist:
	@$(SRCDIR)/.ci/deps install build test
	@$(self) $(jobs) $@-now
bench-page:
	@$(SRCDIR)/.ci/deps install build page
	@$(self) $(jobs) $@-now
bench-peers:
	@$(SRCDIR)/.ci/deps install build peers
	@$(self) $(jobs) $@-now
check verify soak mutants:
	@$(SRCDIR)/.ci/deps install build test
	@$(self) $(jobs) $@-now
check-arm64:
	@$(SRCDIR)/.ci/deps install build arm64
	@$(self) $(jobs) $@-now
check-clients:
	@$(SRCDIR)/.ci/deps install build clients
	@$(self) $(jobs) $@-now
check-kernel:
	@$(SRCDIR)/.ci/deps install build kernel
	@$(self) $(jobs) $@-now
lint:
	@$(SRCDIR)/.ci/deps install build test lint
	@$(self) $(jobs) $@-now

deb:
	@$(SRCDIR)/.ci/deps install build test deb
	@$(SRCDIR)/.ci/deb
DISTROS ?= bookworm trixie
check-distro:
	@for d in $(DISTROS); do $(SRCDIR)/.ci/distro $$d || exit 1; done
fuzz:
	@$(SRCDIR)/.ci/deps install build fuzz
	@$(self) $(jobs) BUILD=fuzz CC=clang CXX=clang++ $@-now

RUN := $(BUILDROOT)/run
# not for run-now alone: make 4.3 takes such a variable out of the environment of every other recipe
SCENE ?= $(if $(scene_copies),$(SRCDIR),$(BUILDROOT))/scenes/first-light.json
DEVICE ?= sim:$(RUN)/sim
run-now: all
	@mkdir -p $(RUN)/sim $(RUN)/state $(RUN)/export
	@$(if $(filter sim:%,$(DEVICE)),echo 'images appear with the first frame: $(abspath $(firstword $(subst $(comma), ,$(DEVICE:sim:%=%))))/panel.png (the panel)$(comma) view.png (as an eye sees it)$(comma) quilt.png (all views)')
	@echo 'control it with: $(abspath $(if $(links),$(BUILDROOT),$(O)))/quiltctl --socket $(call socket) status'
	@$(O)/quiltd '$(SCENE)' --device '$(DEVICE)' --socket '$(call socket)' --state '$(RUN)/state' --export-dir '$(RUN)/export' \
	 $(if $(RUN_FOR),--run-for $(RUN_FOR)) $(if $(filter-out 0,$(WEB)),--web$(patsubst %,=%,$(filter-out 1,$(WEB)))) $(ARGS)
# a socket's path has 107 bytes: the absolute one when it fits
socket = $(shell p='$(abspath $(RUN))/sock'; if [ $${#p} -lt 108 ]; then echo "$$p"; else echo '$(RUN)/sock'; fi)

clean:
	rm -rf $(O) $(links) $(scene_copies) $(BUILDROOT)/deps.mk $(BUILDROOT)/scenes $(BUILDROOT)/tools

help:
	@sed -n '/^[^#]/q; s/^# \{0,1\}//p' $(MAKEFILE)

# needs python3, and nothing else
.PHONY: python
python:
	@python3 $(SRCDIR)/clients/python/backend.py $(BUILDROOT)

# ---------------------------------------------------------------------------------------------------------- lint --
lint_srcs = $(filter-out %.cc,$(foreach l,$(libraries),$($(l)_srcs)) $(foreach p,$(programs),$($(p)_srcs)))
lint-now: $(if $(generated),$(addprefix $(O)/,$(generated)))
	@O='$(O)' SRCDIR='$(SRCDIR)' CFLAGS='$(filter-out -O% -g%,$(lf_cflags))' AVX2='$(isa_render/plane/kernel_avx2)' AVX512='$(isa_render/plane/kernel_avx512)' \
	 $(SRCDIR)/.ci/lint $(lint_srcs)

# ------------------------------------------------------------------------------------------------------- installing --
include $(SRCDIR)/.ci/install.mk

-include $(patsubst %.o,%.d,$(call objs,$(sort $(foreach l,$(libraries),$($(l)_srcs)) $(foreach p,$(programs),$($(p)_srcs)) $(foreach l,$(test_libraries),$($(l)_srcs)) $(addprefix faults/,$(test_faults_render)) $(test_srcs) $(fuzz_srcs) $(kernel_srcs) tests/arm64/results.c)))
-include $(addsuffix .d,$(headers_alone))

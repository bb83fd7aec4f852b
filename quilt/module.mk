quilt_srcs := $(call without_isa,$(call module_files,quilt,*.c))

# shipped profiles of lens sheets and printers, beside the programs' folder as they are installed
profile_data := $(patsubst quilt/%,%,$(call wild,quilt/profiles/lenses/*.json) $(call wild,quilt/profiles/printers/*.json))
all: $(addprefix $(BUILDROOT)/,$(profile_data))
$(BUILDROOT)/profiles/%.json: $(SRCDIR)/quilt/profiles/%.json
	@mkdir -p $(@D)
	@cp $< $@

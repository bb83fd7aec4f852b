# make install DESTDIR= PREFIX=
MANDIR ?= $(DATADIR)/man
SCENEDIR ?= $(DATADIR)/quiltd/scenes
# Debian's zsh looks at vendor-completions beneath /usr and at site-functions beneath /usr/local
ZSHDIR ?= $(DATADIR)/zsh/$(if $(filter /usr/local,$(PREFIX)),site-functions,vendor-completions)
man_pages := $(call wild,docs/man/*.[1-9])
to = $(INSTALL) -D -m $(1) $(2) $(DESTDIR)$(3)
filled = sed -e 's|@BINDIR@|$(BINDIR)|g' -e 's|@SCENEDIR@|$(SCENEDIR)|g' $(SRCDIR)/systemd/$(1).in > $(O)/$(1)

units := quiltd.service quiltd.socket quiltweb.service quiltweb.socket
# services of quiltweb for other programs, off until they are enabled, for the system or for the session of a user
service_units := $(patsubst %,quiltweb-%.socket,bridge events webxr)
# nng's socket belongs to the user whose programs it is for. The manager of a session filters no addresses.
user_units := quiltweb.socket $(service_units) quiltweb-nng.socket

# what shells complete, written by the programs from their tables
completed := quiltd quiltctl quiltrender quiltfarm quiltmerge quiltprint quiltsim quiltbench quiltweb
shells := bash zsh fish
completions := $(foreach s,$(shells),$(patsubst %,$(O)/completions/%.$(s),$(completed)))
define completion
$(O)/completions/%.$(1): $(O)/%
	@mkdir -p $$(@D)
	@$$< --completion $(1) > $$@.new && mv $$@.new $$@
endef
$(foreach s,$(shells),$(eval $(call completion,$(s))))

install: all $(completions)
	@for p in $(filter-out $(readers),$(notdir $(built))); do $(call to,755,$(O)/$$p,$(BINDIR)/$$p) || exit 1; done
	@for p in $(readers); do $(call to,755,$(O)/$$p,$(BINDIR)/../libexec/quiltd/$$p) || exit 1; done
	@for f in $(man_pages); do $(call to,644,$(SRCDIR)/$$f,$(MANDIR)/man$${f##*.}/$${f##*/}) || exit 1; done
	@for p in $(completed); do $(call to,644,$(O)/completions/$$p.bash,$(DATADIR)/bash-completion/completions/$$p) && \
	 $(call to,644,$(O)/completions/$$p.zsh,$(ZSHDIR)/_$$p) && \
	 $(call to,644,$(O)/completions/$$p.fish,$(DATADIR)/fish/vendor_completions.d/$$p.fish) || exit 1; done
	@for f in $(profile_data); do $(call to,644,$(BUILDROOT)/$$f,$(dir $(SCENEDIR))$${f#profiles/}) || exit 1; done
	@for f in $(scene_data); do $(call to,644,$(BUILDROOT)/$$f,$(SCENEDIR)/$${f#scenes/}) || exit 1; done
	@for f in scene.schema.json $(patsubst docs/%,%,$(call wild,docs/guide/*.md) $(call wild,docs/reference/*.md) $(call wild,docs/reference/formats/*.md) $(call wild,docs/reference/*.py) $(call wild,docs/guide/images/*) $(call wild,docs/developer/*.md) $(call wild,docs/developer/estimators/*.md)); do $(call to,644,$(SRCDIR)/docs/$$f,$(dir $(SCENEDIR))docs/$$f) || exit 1; done
	@for u in $(units) $(service_units); do $(call filled,$$u) && $(call to,644,$(O)/$$u,$(UNITDIR)/$$u) || exit 1; done
	@$(call filled,quiltweb-user.service) && $(call to,644,$(O)/quiltweb-user.service,$(USERUNITDIR)/quiltweb.service)
	@for u in $(user_units); do $(call filled,$$u) && sed '/^IPAddress/d' $(O)/$$u > $(O)/user-$$u && $(call to,644,$(O)/user-$$u,$(USERUNITDIR)/$$u) || exit 1; done
	@$(call to,644,$(SRCDIR)/systemd/quiltd.sysusers,$(SYSUSERSDIR)/quiltd.conf)
	@$(call to,644,$(SRCDIR)/systemd/quiltd.tmpfiles,$(TMPFILESDIR)/quiltd.conf)
	@$(call to,644,$(SRCDIR)/systemd/70-quiltd.rules,$(UDEVDIR)/70-quiltd.rules)
	@$(call to,644,$(SRCDIR)/systemd/60-quiltd.polkit.rules,$(POLKITDIR)/60-quiltd.rules)
	@echo 'installed below $(DESTDIR)$(PREFIX); now run as root: systemd-sysusers && systemd-tmpfiles --create && udevadm control --reload'
	@echo 'and for the service: systemctl daemon-reload && systemctl enable --now quiltd; adduser NAME quiltd for each user who may control it'
	@echo 'and for its page in a browser of this machine: systemctl enable --now quiltweb; cat /run/quiltweb/url'
	@echo 'and for other programs of your session, such as WebXR pages: systemctl --user enable --now quiltweb-webxr.socket; see docs/guide/programs.md'

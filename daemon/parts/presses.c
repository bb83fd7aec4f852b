#include "daemon/parts/presses.h"

#include <stdlib.h>

#include "base/alloc.h"

/* Presses between two loads are added up. A user who presses faster than scenes load gets to the
 * last one, and a panel with bouncing buttons does not block other work. */
#define MAX_TURNS 1000000

typedef enum reset_state {
    RESET_REST,
    RESET_BUSY,
    RESET_AGAIN, /* busy, and requested again */
} reset_state;

struct lf_presses {
    lf_presses_events events;
    void *context;
    json_t *camera;    /* camera block of the scene's file, shared with the scene */
    char *browsed;     /* current position of browsing; NULL = the shown file */
    bool browsing;     /* a requested scene is being loaded */
    int turns;         /* presses since that load began (previous: negative) */
    reset_state reset; /* state of the camera reset */
};

lf_status lf_presses_create(const lf_presses_events *events, void *context,
                            lf_presses **out_presses)
{
    lf_presses *presses = lf_calloc(1, sizeof *presses);
    if (!presses)
        return LF_E_NOMEM;
    *presses = (lf_presses){.events = *events, .context = context};
    *out_presses = presses;
    return LF_OK;
}

void lf_presses_destroy(lf_presses *presses)
{
    if (!presses)
        return;
    json_decref(presses->camera);
    lf_free(presses->browsed);
    lf_free(presses);
}

/* ---------------------------------------------------------------------------------- browsing -- */

/* Loads one file at a time. The loader's thread reads the folder, which may be large or on a drive
 * that does not answer. */
static void browse(lf_presses *presses, const char *from)
{
    int step = presses->turns;
    if (from && presses->browsing)
        return;
    presses->turns = 0;
    if (from)
        presses->browsing = presses->events.browse(presses->context, from, step);
}

void lf_presses_turn(lf_presses *presses, int step, const char *shown)
{
    if (abs(presses->turns) < MAX_TURNS)
        presses->turns += step;
    if (presses->turns != 0)
        browse(presses, presses->browsed ? presses->browsed : shown);
}

void lf_presses_browsed(lf_presses *presses, const char *file)
{
    presses->browsing = false;
    /* Later presses continue from here, also if this file cannot be shown. */
    lf_free(presses->browsed);
    presses->browsed = lf_strdup(file);
    if (presses->turns != 0)
        browse(presses, presses->browsed);
}

void lf_presses_file(lf_presses *presses, json_t *camera, bool browsed)
{
    presses->events.release(presses->context, presses->camera);
    presses->camera = camera ? json_incref(camera) : json_object();
    if (!browsed) {
        lf_free(presses->browsed);
        presses->browsed = NULL;
    }
}

/* --------------------------------------------------------------------------------- resetting -- */

/* One reset in progress and one queued after it are enough for any number of presses. */
void lf_presses_reset(lf_presses *presses)
{
    if (presses->reset != RESET_REST)
        presses->reset = RESET_AGAIN;
    else if (presses->camera && presses->events.reset(presses->context, presses->camera))
        presses->reset = RESET_BUSY;
}

void lf_presses_was_reset(lf_presses *presses)
{
    bool again = presses->reset == RESET_AGAIN;
    presses->reset = RESET_REST;
    if (again)
        lf_presses_reset(presses);
}

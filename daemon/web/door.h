/* door: whose requests come in at a port. Every listening socket belongs to a door, and each door
 * has a port, a guard and paths of its own. */
#ifndef LF_DAEMON_WEB_DOOR_H
#define LF_DAEMON_WEB_DOOR_H

typedef enum lf_door {
    LF_DOOR_PAGE,   /* the page, and programs that know the token */
    LF_DOOR_BRIDGE, /* requests of programs that speak to Looking Glass Bridge, by default 33334 */
    LF_DOOR_EVENTS, /* what Bridge tells such programs, by default 9724 */
    LF_DOOR_WEBXR,  /* pages that draw for themselves and ask for the panel, by default 11222 */
    LF_DOORS,
} lf_door;

#endif

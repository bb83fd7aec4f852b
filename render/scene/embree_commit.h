/* Building Embree's hierarchy of a scene, which may be ended; private to render/. */
#ifndef LF_RENDER_EMBREE_COMMIT_H
#define LF_RENDER_EMBREE_COMMIT_H

#include "base/status.h"
#include "render/scene/embree.h"

/* rtcCommitScene. LF_E_CANCELLED: lf_import_is_stopped, soon after it is; LF_E_NOMEM: Embree's
 * error in words. */
LF_NODISCARD lf_status lf_embree_commit(RTCScene scene, RTCDevice device, lf_error *err);

#endif

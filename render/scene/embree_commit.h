/* Building Embree's BVH of a scene, with cancellation; private to render/. */
#ifndef LF_RENDER_EMBREE_COMMIT_H
#define LF_RENDER_EMBREE_COMMIT_H

#include "base/status.h"
#include "render/scene/embree.h"

/* rtcCommitScene. LF_E_CANCELLED soon after lf_import_is_stopped becomes true; LF_E_NOMEM with
 * Embree's error message. */
LF_NODISCARD lf_status lf_embree_commit(RTCScene scene, RTCDevice device, lf_error *err);

#endif

#include "render/scene/embree_commit.h"

#include "base/sandbox/import_group.h"

/* On any of Embree's threads. */
static bool goes_on(void *context, double done)
{
    (void)done;
    return !lf_import_group_is_stopped(context);
}

lf_status lf_embree_commit(RTCScene scene, RTCDevice device, lf_error *err)
{
    lf_import_group *group = lf_import_group_current();
    if (lf_import_group_is_stopped(group))
        return lf_import_say_stopped("meshes", err);
    rtcSetSceneProgressMonitorFunction(scene, goes_on, group);
    rtcCommitScene(scene);
    rtcSetSceneProgressMonitorFunction(scene, NULL, NULL);
    enum RTCError problem = rtcGetDeviceError(device);
    if (problem == RTC_ERROR_CANCELLED)
        return lf_import_say_stopped("meshes", err);
    return problem == RTC_ERROR_NONE
               ? LF_OK
               : lf_error_set(err, LF_E_NOMEM, "meshes",
                              "Embree cannot build the hierarchy (error %d)", (int)problem);
}

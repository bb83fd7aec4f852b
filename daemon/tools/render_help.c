/* The help of quiltrender. */
#include <stdio.h>

#include "daemon/tools/render_arguments.h"

void lf_render_help(void)
{
    printf("Usage: quiltrender SCENE -o OUT [options]\n"
           "       quiltrender --chart LPI+-RANGE/STEP@DPI --print-size WxH -o OUT.tif [options]\n"
           "       quiltrender --read-chart PHOTO.jpg [--chart-file CHART.json] [-o RESULT.json]\n"
           "       quiltrender PRINT.tif --simulate -o OUT [options]\n"
           "       quiltrender --state-info FILE\n"
           "Render a scene (JSON) to a quilt, an interlaced panel image, a lenticular print or a "
           "folder of views.\n"
           "SCENE may also be a mesh or a volume (.glb, .obj, .vdb ...), which quiltrender frames "
           "and lights,\n"
           "or a finished quilt image or folder of views, which it does not render again.\n\n"
           "The ending of OUT chooses the output: .png, .exr or .jpg a quilt, named "
           "..._qsCxRaASPECT, or one view, as named;\n"
           ".tif a print; .mp4 a video; .gif a loop; a path ending in / a folder of views.\n\n"
           "What to render:\n");
    lf_param_print_help(lf_option_params,
                        LF_OPTIONS_VIEWS " fit exposure panel png still quality aov guides");
    lf_param_print_help(lf_panel_params, NULL);
    lf_param_print_help(lf_response_params, NULL);
    lf_param_print_help(lf_print_params, NULL);
    lf_param_print_help(lf_profile_params, NULL);
    lf_param_print_help(lf_check_params, NULL);
    lf_param_print_help(lf_rgbd_params, NULL);
    lf_param_print_help(lf_hologram_params, NULL);
    lf_param_print_help(lf_alone_params, NULL);
    lf_param_print_help(lf_photo_params, NULL);
    lf_param_print_help(lf_picture_params, NULL);
    lf_param_print_help(lf_standing_params, LF_RENDER_STANDING);
    printf("\n"
           "How long to render (one of these; default --passes %d, or --spp %d without "
           "denoising):\n"
           "  --passes N             render N base paths per pixel of one view\n"
           "  --spp N                render N base paths per view pixel\n"
           "  --time SECONDS         render as many pairs of passes as fit into SECONDS, at "
           "least one\n",
           LF_RENDER_DEFAULT_PASSES, LF_RENDER_DEFAULT_SPP);
    lf_param_print_help(lf_option_params, "target-error target-denoised-error");
    printf("\nA finished print, seen through its sheet (with --print and the options after it):\n");
    lf_param_print_help(lf_simulate_params, NULL);
    printf("\nSequences (one file per frame: OUT_0001 and so on, or OUT with %%04d):\n");
    lf_param_print_help(lf_frames_params, NULL);
    lf_param_print_help(lf_video_params, NULL);
    printf("\nHow to render:\n");
    lf_param_print_help(lf_option_params, LF_OPTIONS_RENDER " light-paths suffixes");
    lf_param_print_help(lf_integrator_params(), NULL);
    lf_param_print_help(lf_option_params, LF_OPTIONS_IMPORT);
    printf("  --state FILE           save the work to FILE, and continue from it (exit status 75: "
           "interrupted)\n");
    lf_param_print_help(lf_state_params, NULL);
    printf("  --state-info FILE      print the contents of a state file as JSON\n"
           "  --read-chart PHOTO     read pitch, phase and skew from a photo of a chart under its "
           "sheet\n"
           "  --chart-file FILE      manifest of this chart (chart.json in the photo's folder)\n"
           "  --stats FILE.json      write statistics as JSON (-: standard output)\n"
           "  --files FILE.json      write the names, sizes and SHA-256 of all written files as "
           "JSON\n"
           "  --plan                 print estimated costs and one command per task; render "
           "nothing\n"
           "  --json                 print the plan as one JSON object\n"
           "  --task-minutes M       divide the plan into tasks of about M minutes; 0: one light "
           "field per task (%d)\n"
           "  --task-memory SIZE     divide the plan into tasks of at most SIZE, such as 2G (no "
           "limit)\n" LF_OPTIONS_HELP_LAST LF_OPTIONS_HELP_SHELLS,
           LF_PLAN_MINUTES);
}

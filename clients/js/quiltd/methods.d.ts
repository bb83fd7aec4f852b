// Written by `make docs` from the answer of `hello`.

export interface Calls {
  /** return version, protocol, methods and notifications */
  "hello": {
    params: {};
    result: {
      /** name of the program: quiltd */
      "name"?: string;
      /** version of quiltd */
      "version"?: string;
      /** version of the protocol [count] */
      "protocol"?: number;
      /** folders from which clients may name files */
      "folders"?: string[];
      /** farms that an export may name */
      "farms"?: string[];
      /** methods by name, each with summary, params and result (JSON Schemas) and example */
      "methods"?: { [key: string]: unknown };
      /** notifications by name, each with summary, event (for subscribe) and params (JSON Schema) */
      "events"?: { [key: string]: unknown };
      /** true: this connection may call only some of quiltd's methods */
      "limited"?: boolean;
    };
  };
  /** return the state of the daemon */
  "status": {
    params: {};
    result: {
      /** rendering, converged, paused, idle or error */
      "state"?: string;
      /** why the scene could not be loaded; absent if it was loaded */
      "error"?: {
        /** error code, as in an error response [count] */
        "code"?: number;
        /** what is wrong and what to do, in one line */
        "message"?: string;
        /** where the error is, if known */
        "data"?: {
          /** file or option with the error */
          "file"?: string;
          /** line in this file, from 1 [count] */
          "line"?: number;
          /** JSON pointer of the value */
          "pointer"?: string;
        };
      };
      /** file on display */
      "scene"?: string | null;
      /** files and arrays of the scene that clients passed as descriptors */
      "passed"?: string[];
      /** true: a finished image is on display, not a rendering */
      "is_quilt"?: boolean;
      /** true: its views were drawn from an image with depth; only with is_quilt */
      "is_rgbd"?: boolean;
      /** how the finished image stands, as the keys of scene.load; only with is_quilt */
      "standing"?: { [key: string]: unknown };
      /** number of views [count] */
      "views"?: number;
      /** columns of the quilt [count] */
      "columns"?: number;
      /** rows of the quilt [count] */
      "rows"?: number;
      /** width of one view [pixels] */
      "view_width"?: number;
      /** height of one view [pixels] */
      "view_height"?: number;
      /** aspect of the focal plane [width over height] */
      "aspect"?: number;
      /** total angle over which the cameras are spread, seen from the target [degrees] */
      "cone"?: number;
      /** length of the camera track [scene units] */
      "track"?: number;
      /** current frame, and playback */
      "time"?: {
        /** frame number [frames] */
        "frame"?: number;
        /** true: frames are being played */
        "playing"?: boolean;
        /** playback speed; absent unless playing [frames per second] */
        "fps"?: number;
        /** former name of fps [frames per second] */
        "rate"?: number;
        /** first frame, during playback [frames] */
        "from"?: number;
        /** last frame, during playback [frames] */
        "to"?: number;
        /** true: loop, during playback */
        "loop"?: boolean;
      };
      /** whether the scene is too deep for a panel */
      "depth_budget"?: {
        /** distance of the nearest point [scene units] */
        "nearest"?: number;
        /** distance of the farthest point [scene units] */
        "farthest"?: number;
        /** shift of this point between views [pixels] */
        "nearest_step"?: number | null;
        /** shift of this point between views [pixels] */
        "farthest_step"?: number;
        /** largest shift that the panel shows sharply [pixels] */
        "limit"?: number;
        /** nearest sharp distance [scene units] */
        "sharp_from"?: number;
        /** farthest sharp distance; null: no limit [scene units] */
        "sharp_to"?: number | null;
        /** true: the scene exceeds these distances and has no view_blur */
        "exceeded"?: boolean;
      } | null;
      /** random seed; a string if it exceeds 2^63 - 1 [count] */
      "seed"?: number | string;
      /** name of the integrator */
      "integrator"?: string;
      /** number of the scene and camera state [count] */
      "generation"?: number;
      /** level of the image: none, coarse, complete or converged */
      "level"?: string;
      /** passes rendered so far [passes] */
      "passes"?: number;
      /** rendering time so far [seconds] */
      "seconds"?: number;
      /** CPU time of all threads so far [seconds] */
      "cpu_seconds"?: number;
      /** mean native samples of a view pixel [samples per pixel] */
      "spp"?: number | null;
      /** estimated error of the unfiltered image [relMSE] */
      "error_estimate"?: number | null;
      /** 95 % upper bound of this error [relMSE] */
      "error_bound"?: number | null;
      /** estimated rendering time until the error meets target_error [seconds] */
      "seconds_left"?: number | null;
      /** error of the denoised image [relMSE] */
      "denoised_error"?: number | null;
      /** 95 % upper bound of this error [relMSE] */
      "denoised_error_bound"?: number | null;
      /** former name of denoised_error [relMSE] */
      "shown_error"?: number | null;
      /** former name of denoised_error_bound [relMSE] */
      "shown_error_bound"?: number | null;
      /** cost of the last image up to its first coarse frame; null: none yet */
      "coarse_cost"?: {
        /** all threads: rows with paths [CPU seconds] */
        "paths"?: number;
        /** all threads: rows without paths yet [CPU seconds] */
        "fans"?: number;
        /** all threads: fitting the denoiser [CPU seconds] */
        "fit"?: number;
        /** all threads: denoised rows [CPU seconds] */
        "answer"?: number;
        /** all threads: tone mapping and interlacing [CPU seconds] */
        "compose"?: number;
      } | null;
      /** cost of the last image up to its first complete frame, the coarse one included */
      "complete_cost"?: {
        /** all threads: rows with paths [CPU seconds] */
        "paths"?: number;
        /** all threads: rows without paths yet [CPU seconds] */
        "fans"?: number;
        /** all threads: fitting the denoiser [CPU seconds] */
        "fit"?: number;
        /** all threads: denoised rows [CPU seconds] */
        "answer"?: number;
        /** all threads: tone mapping and interlacing [CPU seconds] */
        "compose"?: number;
      } | null;
      /** view pixels that no path has reached yet [pixels] */
      "missing"?: number;
      /** number of worker threads [count] */
      "threads"?: number;
      /** name of the estimator */
      "estimator"?: string;
      /** error at which rendering stops; 0: never [relMSE] */
      "target_error"?: number;
      /** true: rendering is paused; of a video: it holds the current frame */
      "paused"?: boolean;
      /** true: what is too near or too far is tinted */
      "guides"?: boolean;
      /** on: the denoised image is shown, once there is one; off: the unfiltered */
      "denoise"?: string;
      /** former name of denoise */
      "reconstruct"?: string;
      /** exposure and tone curve */
      "exposure"?: {
        /** exposure in use [stops] */
        "stops"?: number;
        /** true: quiltd chose it from the image */
        "auto"?: boolean;
        /** name of the tone curve */
        "tonemap"?: string;
      };
      /** the frame on the panel */
      "shown"?: {
        /** number of the scene and camera state [count] */
        "generation"?: number;
        /** none, coarse, complete or converged */
        "level"?: string;
        /** denoised, unfiltered or card */
        "image"?: string;
        /** former image: reconstructed, unfiltered or card */
        "picture"?: string;
        /** text on the card; null: no card */
        "card"?: string | null;
      };
      /** warnings about the scene and its image */
      "warnings"?: string[];
      /** the panel that is open */
      "device"?: {
        /** device spec for --device and device.set */
        "spec"?: string;
        /** kind of device, such as sim or none */
        "kind"?: string;
        /** name of the display, if it has one */
        "model"?: string;
        /** serial number of the panel */
        "serial"?: string;
        /** where the calibration came from */
        "calibration_from"?: string;
        /** file, connector or USB address */
        "output"?: string;
        /** what is wrong and what to do; empty if all is well */
        "problem"?: string;
        /** true: the device is open; absent in lists */
        "present"?: boolean;
        /** response of the panel; absent in lists */
        "response"?: {
          /** gamma: a number or srgb [exponent] */
          "gamma"?: number | string;
          /** colour temperature of the white; 0: not set [kelvin] */
          "white"?: number;
          /** chromaticity of the white; 0: not set [CIE x] */
          "white_x"?: number;
          /** chromaticity of the white; 0: not set [CIE y] */
          "white_y"?: number;
        };
      };
      /** updates pushed to the panel [count] */
      "updates"?: number;
      /** bytes pushed to the panel [bytes] */
      "bytes"?: number;
      /** updates that the panel did not accept [count] */
      "device_errors"?: number;
      /** number of loads waiting or in progress [count] */
      "loading"?: number;
      /** the load in progress */
      "load"?: {
        /** job number of the load, for job.cancel [count] */
        "job"?: number;
        /** file, patch, orbit, fit or settings */
        "kind"?: string;
        /** file being loaded */
        "file"?: string | null;
      } | null;
      /** file being read */
      "reading"?: {
        /** file being read, one of the scene's files */
        "file"?: string;
        /** size of this file [bytes] */
        "bytes"?: number;
        /** time spent on this file so far [seconds] */
        "seconds"?: number;
        /** number of files read before [count] */
        "files_read"?: number;
      } | null;
      /** Landlock confinement of the file readers: on, off, refused or unknown */
      "landlock"?: string;
      /** number of connected clients [count] */
      "clients"?: number;
      /** number of client lines handled so far [count] */
      "lines"?: number;
      /** exports waiting or running */
      "jobs"?: ({
        /** job number of the export [count] */
        "job"?: number;
        /** kind of the export */
        "kind"?: string;
        /** file being written */
        "file"?: string;
        /** waiting, running, done, failed or cancelled */
        "state"?: string;
        /** share written, or of a farm's tasks that are complete, from 0 to 1 [share] */
        "progress"?: number;
        /** the farm that renders it; absent if quiltd does */
        "farm"?: {
          /** slurm, parallel or list */
          "engine"?: string;
          /** folder of the job, for quiltfarm */
          "folder"?: string;
          /** planning, submitting, planned, queued, running, merging, interrupted, failed or complete */
          "state"?: string;
          /** its tasks */
          "tasks"?: {
            /** all tasks; 0: not known yet [count] */
            "total"?: number;
            /** tasks whose results are there [count] */
            "complete"?: number;
            /** tasks that run [count] */
            "running"?: number;
            /** tasks that have failed [count] */
            "failed"?: number;
            /** tasks that have no result yet [count] */
            "missing"?: number;
          };
          /** CPU time of all tasks */
          "cpu_seconds"?: {
            /** what quiltfarm expects; null: unknown [seconds] */
            "planned"?: number | null;
            /** what was used so far; null: unknown [seconds] */
            "spent"?: number | null;
          };
          /** time to its end; null: unknown [seconds] */
          "seconds_left"?: number | null;
          /** why quiltfarm did not say how far it is; null: it did */
          "problem"?: string | null;
        };
      })[];
      /** the slideshow; null: no entries */
      "playlist"?: {
        /** number of the current entry, from 0 [count] */
        "index"?: number;
        /** true: the entries are shown in turn */
        "playing"?: boolean;
        /** true: the time of the current entry is stopped */
        "paused"?: boolean;
        /** number of entries [count] */
        "entries"?: number;
        /** file of the current entry */
        "file"?: string;
      } | null;
      /** the video on display; null: none */
      "video"?: {
        /** its file */
        "file"?: string;
        /** width of its images [pixels] */
        "width"?: number;
        /** height of its images [pixels] */
        "height"?: number;
        /** its rate [frames per second] */
        "fps"?: number;
        /** position of the current frame [seconds] */
        "seconds"?: number;
        /** its length; null: unknown [seconds] */
        "duration"?: number | null;
        /** number of the current frame, from 0 in each round [frames] */
        "frame"?: number;
        /** frames that the panel took [frames] */
        "shown"?: number;
        /** frames that were late, or that the panel did not take [frames] */
        "dropped"?: number;
        /** true: it holds the current frame */
        "paused"?: boolean;
        /** why it has stopped and holds its last frame; null: it plays */
        "problem"?: string | null;
      } | null;
      /** time since the daemon started [seconds] */
      "uptime"?: number;
      /** longest CPU time of the event thread for one event [seconds] */
      "longest_turn"?: number;
    };
  };
  /** show a scene file, a model, a volume or a quilt image */
  "scene.load": {
    params: {
      /** path of a scene, model, volume, quilt image, quilt video or folder of views; quiltctl makes it absolute */
      "file"?: string;
      /** scene document, instead of file; its paths are absolute */
      "scene"?: { [key: string]: unknown };
      /** the scene document comes as the first descriptor, instead of file; at most 16 MiB */
      "scene_fd"?: boolean;
      /** name of scene or scene_fd in messages, at most 128 bytes without / (scene) */
      "name"?: string;
      /** arrays of the scene by name, each {shape, type}; their descriptors come after the descriptors of files */
      "arrays"?: { [key: string]: unknown };
      /** tiles COLUMNSxROWS of an image whose name has no _qs suffix */
      "quilt"?: string;
      /** absolute names of the passed files, in the order of their descriptors (SCM_RIGHTS, read-only); quiltctl fills this in */
      "files"?: string[];
      /** file without a scene: how far the eye is to the right of the front (as on the command line, else 22) [degrees] */
      "yaw"?: number;
      /** file without a scene: how far the eye is above the front (as on the command line, else 13) [degrees] */
      "pitch"?: number;
      /** file without a scene: its up axis; file: z in STL files, else y */
      "up"?: "file" | "y" | "z";
      /** file without a scene: dark backdrop, no ground, no studio; of a volume the density grid alone */
      "bare"?: boolean;
      /** image of another shape: show it whole with borders, or cut it to cover the view */
      "photo"?: "fit" | "fill";
      /** position of the image, or the part of it that is kept */
      "photo_position"?: "center" | "left" | "right" | "top" | "bottom" | "top-left" | "top-right" | "bottom-left" | "bottom-right";
      /** turn each image clockwise; auto: by 90 if only one of image and output is upright */
      "photo_rotate"?: "0" | "90" | "180" | "270" | "auto";
      /** width / height of the views of a finished quilt or folder (from its name, images or pixels) */
      "aspect"?: number;
      /** number of views of a quilt image or video; further tiles are unused (all tiles) */
      "views"?: number;
      /** where the depth of an RGBD image is; auto: right if the name ends with _rgbd */
      "rgbd_in"?: "auto" | "off" | "right" | "left" | "top" | "bottom";
      /** on: near is black, far white, in the depth of an RGBD image */
      "depth_inversion"?: "off" | "on";
      /** on: the depth of an RGBD image is a hue, from red, near, to blue, far */
      "chroma_depth"?: "off" | "on";
      /** factor of the depth of an RGBD image */
      "depthiness"?: number;
      /** least depth code of an RGBD image; farther points come up to it */
      "depth_cutoff"?: number;
      /** shift of a finished image: view i of N moves to the right by (2 i/(N-1) - 1) F of its width; above 0 it moves behind the glass */
      "focus"?: number;
      /** scale of a finished image about the middle of the view */
      "zoom"?: number;
      /** part of a finished image in the middle of the view: half widths to the right */
      "crop_x"?: number;
      /** part of a finished image in the middle of the view: half heights down */
      "crop_y"?: number;
    };
    result: {
      /** generation of the scene on display [count] */
      "generation"?: number;
      /** features of its files that the image lacks */
      "warnings"?: string[];
    };
  };
  /** return the current scene */
  "scene.get": {
    params: {};
    result: {
      /** file of the scene */
      "file"?: string;
      /** generation of the scene [count] */
      "generation"?: number;
      /** bounding box of the scene without its grounds */
      "bounds"?: {
        /** minimum x, y and z [scene units] */
        "min"?: number[];
        /** maximum x, y and z [scene units] */
        "max"?: number[];
      } | null;
      /** scene document; null: a finished image is on display */
      "scene"?: { [key: string]: unknown } | null;
    };
  };
  /** change the current scene with a JSON Merge Patch (RFC 7396) */
  "scene.patch": {
    params: {
      /** keys of the scene file with their new values; null removes a key */
      "patch": { [key: string]: unknown };
      /** absolute names of the passed files, in the order of their descriptors (SCM_RIGHTS, read-only); quiltctl fills this in */
      "files"?: string[];
      /** arrays of the scene by name, each {shape, type}; their descriptors come after the descriptors of files */
      "arrays"?: { [key: string]: unknown };
    };
    result: {
      /** generation of the scene on display [count] */
      "generation"?: number;
      /** features of its files that the image lacks */
      "warnings"?: string[];
    };
  };
  /** show a quilt that comes by a passed descriptor, as raw pixels or an image file */
  "quilt.show": {
    params: {
      /** columns of tiles; they divide the width; required, except with rgbd_in [count] */
      "columns"?: number;
      /** rows of tiles; they divide the height; required, except with rgbd_in [count] */
      "rows"?: number;
      /** number of views (columns x rows) [count] */
      "views"?: number;
      /** aspect of a view (a tile's) [width / height] */
      "aspect"?: number;
      /** width of the whole quilt in raw pixels; without it the descriptor is an image file [pixels] */
      "width"?: number;
      /** its height [pixels] */
      "height"?: number;
      /** name in messages, at most 128 bytes without / (quilt) */
      "name"?: string;
      /** where the depth of an RGBD image is; auto: right if the name ends with _rgbd */
      "rgbd_in"?: "auto" | "off" | "right" | "left" | "top" | "bottom";
      /** on: near is black, far white, in the depth of an RGBD image */
      "depth_inversion"?: "off" | "on";
      /** on: the depth of an RGBD image is a hue, from red, near, to blue, far */
      "chroma_depth"?: "off" | "on";
      /** factor of the depth of an RGBD image */
      "depthiness"?: number;
      /** least depth code of an RGBD image; farther points come up to it */
      "depth_cutoff"?: number;
      /** shift of a finished image: view i of N moves to the right by (2 i/(N-1) - 1) F of its width; above 0 it moves behind the glass */
      "focus"?: number;
      /** scale of a finished image about the middle of the view */
      "zoom"?: number;
      /** part of a finished image in the middle of the view: half widths to the right */
      "crop_x"?: number;
      /** part of a finished image in the middle of the view: half heights down */
      "crop_y"?: number;
    };
    result: {
      /** generation of the quilt on display [count] */
      "generation"?: number;
      /** features of its file that the image lacks */
      "warnings"?: string[];
    };
  };
  /** set keys of the camera; other keys keep their values */
  "camera.set": {
    params: {
      /** point in the middle of the window, in the focal plane */
      "target"?: number[];
      /** middle of the line of cameras, at least 1e-9 from target */
      "position"?: number[];
      /** direction that is up in the image; not along the line of sight */
      "up"?: number[];
      /** vertical angle of the window, seen from the centre of the cameras [degrees] */
      "fov_y"?: number;
      /** width / height of the window */
      "aspect"?: number;
      /** number of views, or an object that places the cameras; see Views */
      "views"?: number | { [key: string]: unknown };
      /** view cone: angle over which the cameras are spread, seen from the target [degrees] */
      "cone"?: number;
      /** factor of the view cone in use, also of a panel's own; 0: all views are equal */
      "depthiness"?: number;
      /** inclusive: the outermost cameras are at the ends of the cone; centred: half a spacing inside */
      "placement"?: "centred" | "inclusive";
      /** radius of each view's lens; 0: a pinhole, everything is sharp [scene units] */
      "lens_radius"?: number;
      /** distance along the view axis that is sharp with a lens_radius (distance of target) [scene units] */
      "focus_distance"?: number;
      /** width of each view's aperture along the line of cameras; 0: a pinhole; excludes lens_radius [camera spacings] */
      "view_blur"?: number;
      /** exposure time, see Motion blur; 0: no motion blur [frames] */
      "shutter"?: number;
      /** time at which the shutter opens, relative to the frame; minus half of shutter centres it [frames] */
      "shutter_open"?: number;
    };
    result: {
      /** generation of the scene on display [count] */
      "generation"?: number;
      /** features of its files that the image lacks */
      "warnings"?: string[];
    };
  };
  /** orbit the camera around its target */
  "camera.orbit": {
    params: {
      /** rotation to the right around the target [degrees] */
      "yaw"?: number;
      /** rotation upwards around the target [degrees] */
      "pitch"?: number;
      /** how many times nearer to the target */
      "zoom"?: number;
    };
    result: {
      /** generation of the scene on display [count] */
      "generation"?: number;
    };
  };
  /** move the camera so that the scene, or a part of it, fills the views */
  "camera.fit": {
    params: {
      /** mesh or volume to frame (the scene except its grounds) */
      "name"?: string;
      /** share of the window's width or height that it fills in every view [share of the window] */
      "fill"?: number;
      /** largest shift of any of its points between neighbouring views (no limit) [pixels] */
      "steps"?: number;
    };
    result: {
      /** generation of the scene on display [count] */
      "generation"?: number;
    };
  };
  /** show a frame of the scene */
  "time.set": {
    params: {
      /** number of the frame [frames] */
      "frame": number;
    };
    result: {
      /** generation of the scene on display [count] */
      "generation"?: number;
      /** features of its files that the image lacks */
      "warnings"?: string[];
    };
  };
  /** play frames of the scene */
  "time.play": {
    params: {
      /** first frame (the frame that is shown) [frames] */
      "from"?: number;
      /** last frame, not before from [frames] */
      "to": number;
      /** start again after the last frame */
      "loop"?: boolean;
      /** playback speed (the scene's fps) [frames per second] */
      "fps"?: number;
    };
    result: {
      /** frame number [frames] */
      "frame"?: number;
      /** true: frames are being played */
      "playing"?: boolean;
      /** playback speed; absent unless playing [frames per second] */
      "fps"?: number;
      /** former name of fps [frames per second] */
      "rate"?: number;
      /** first frame, during playback [frames] */
      "from"?: number;
      /** last frame, during playback [frames] */
      "to"?: number;
      /** true: loop, during playback */
      "loop"?: boolean;
    };
  };
  /** stop at the current frame */
  "time.stop": {
    params: {};
    result: {
      /** frame number [frames] */
      "frame"?: number;
      /** true: frames are being played */
      "playing"?: boolean;
      /** playback speed; absent unless playing [frames per second] */
      "fps"?: number;
      /** former name of fps [frames per second] */
      "rate"?: number;
      /** first frame, during playback [frames] */
      "from"?: number;
      /** last frame, during playback [frames] */
      "to"?: number;
      /** true: loop, during playback */
      "loop"?: boolean;
    };
  };
  /** replace the entries of the slideshow */
  "playlist.set": {
    params: {
      /** what to show, in this order: each {file} and the keys of playlist.change; an empty list stops */
      "entries"?: ({
        /** absolute path of a scene, model, volume or image */
        "file": string;
        /** time from the first frame that is shown (a video once through; others the list's) [seconds] */
        "seconds"?: number;
        /** tiles COLUMNSxROWS of an image or video whose name has no _qs suffix */
        "quilt"?: string;
        /** file without a scene: how far the eye is to the right of the front (as on the command line, else 22) [degrees] */
        "yaw"?: number;
        /** file without a scene: how far the eye is above the front (as on the command line, else 13) [degrees] */
        "pitch"?: number;
        /** file without a scene: its up axis; file: z in STL files, else y */
        "up"?: "file" | "y" | "z";
        /** file without a scene: dark backdrop, no ground, no studio; of a volume the density grid alone */
        "bare"?: boolean;
        /** image of another shape: show it whole with borders, or cut it to cover the view */
        "photo"?: "fit" | "fill";
        /** position of the image, or the part of it that is kept */
        "photo_position"?: "center" | "left" | "right" | "top" | "bottom" | "top-left" | "top-right" | "bottom-left" | "bottom-right";
        /** turn each image clockwise; auto: by 90 if only one of image and output is upright */
        "photo_rotate"?: "0" | "90" | "180" | "270" | "auto";
        /** width / height of the views of a finished quilt or folder (from its name, images or pixels) */
        "aspect"?: number;
        /** number of views of a quilt image or video; further tiles are unused (all tiles) */
        "views"?: number;
        /** where the depth of an RGBD image is; auto: right if the name ends with _rgbd */
        "rgbd_in"?: "auto" | "off" | "right" | "left" | "top" | "bottom";
        /** on: near is black, far white, in the depth of an RGBD image */
        "depth_inversion"?: "off" | "on";
        /** on: the depth of an RGBD image is a hue, from red, near, to blue, far */
        "chroma_depth"?: "off" | "on";
        /** factor of the depth of an RGBD image */
        "depthiness"?: number;
        /** least depth code of an RGBD image; farther points come up to it */
        "depth_cutoff"?: number;
        /** shift of a finished image: view i of N moves to the right by (2 i/(N-1) - 1) F of its width; above 0 it moves behind the glass */
        "focus"?: number;
        /** scale of a finished image about the middle of the view */
        "zoom"?: number;
        /** part of a finished image in the middle of the view: half widths to the right */
        "crop_x"?: number;
        /** part of a finished image in the middle of the view: half heights down */
        "crop_y"?: number;
      })[];
      /** folder whose pictures, quilts, videos, scenes, models and volumes are shown in natural order, instead of entries */
      "folder"?: string;
      /** default time of an entry; a video plays once through [seconds] */
      "seconds"?: number;
      /** start again after the last entry */
      "loop"?: boolean;
      /** time in which an image turns into the next one [seconds] */
      "crossfade"?: number;
      /** check all and answer as usual, but change nothing */
      "check"?: boolean;
    };
    result: {
      /** what is shown, in this order */
      "entries"?: {
        /** path of the file */
        "file"?: string;
        /** time from the first frame that is shown; absent: not given [seconds] */
        "seconds"?: number;
        /** tiles COLUMNSxROWS; absent: not given */
        "quilt"?: string;
        /** as of scene.load; this and all below absent: not given [degrees] */
        "yaw"?: number;
        /** as of scene.load [degrees] */
        "pitch"?: number;
        /** as of scene.load */
        "up"?: string;
        /** as of scene.load */
        "bare"?: boolean;
        /** as of scene.load */
        "photo"?: string;
        /** as of scene.load */
        "photo_position"?: string;
        /** as of scene.load */
        "photo_rotate"?: string;
        /** as of scene.load [width over height] */
        "aspect"?: number;
        /** as of scene.load [count] */
        "views"?: number;
        /** as of scene.load */
        "rgbd_in"?: string;
        /** as of scene.load */
        "depth_inversion"?: string;
        /** as of scene.load */
        "chroma_depth"?: string;
        /** as of scene.load [factor] */
        "depthiness"?: number;
        /** as of scene.load [code] */
        "depth_cutoff"?: number;
        /** as of scene.load [widths] */
        "focus"?: number;
        /** as of scene.load [factor] */
        "zoom"?: number;
        /** as of scene.load [half widths] */
        "crop_x"?: number;
        /** as of scene.load [half heights] */
        "crop_y"?: number;
      }[];
      /** folder that the entries are from; null: none */
      "folder"?: string | null;
      /** true: the folder has more files than entries */
      "more"?: boolean;
      /** number of the current entry, from 0 [count] */
      "index"?: number;
      /** times that the slideshow has begun to load an entry [count] */
      "turn"?: number;
      /** true: the entries are shown in turn */
      "playing"?: boolean;
      /** true: the time of the current entry is stopped */
      "paused"?: boolean;
      /** true: starts again after the last entry */
      "loop"?: boolean;
      /** default time of an entry; a video plays once through [seconds] */
      "seconds"?: number;
      /** time in which an image turns into the next one [seconds] */
      "crossfade"?: number;
    };
  };
  /** return the slideshow */
  "playlist.get": {
    params: {};
    result: {
      /** what is shown, in this order */
      "entries"?: {
        /** path of the file */
        "file"?: string;
        /** time from the first frame that is shown; absent: not given [seconds] */
        "seconds"?: number;
        /** tiles COLUMNSxROWS; absent: not given */
        "quilt"?: string;
        /** as of scene.load; this and all below absent: not given [degrees] */
        "yaw"?: number;
        /** as of scene.load [degrees] */
        "pitch"?: number;
        /** as of scene.load */
        "up"?: string;
        /** as of scene.load */
        "bare"?: boolean;
        /** as of scene.load */
        "photo"?: string;
        /** as of scene.load */
        "photo_position"?: string;
        /** as of scene.load */
        "photo_rotate"?: string;
        /** as of scene.load [width over height] */
        "aspect"?: number;
        /** as of scene.load [count] */
        "views"?: number;
        /** as of scene.load */
        "rgbd_in"?: string;
        /** as of scene.load */
        "depth_inversion"?: string;
        /** as of scene.load */
        "chroma_depth"?: string;
        /** as of scene.load [factor] */
        "depthiness"?: number;
        /** as of scene.load [code] */
        "depth_cutoff"?: number;
        /** as of scene.load [widths] */
        "focus"?: number;
        /** as of scene.load [factor] */
        "zoom"?: number;
        /** as of scene.load [half widths] */
        "crop_x"?: number;
        /** as of scene.load [half heights] */
        "crop_y"?: number;
      }[];
      /** folder that the entries are from; null: none */
      "folder"?: string | null;
      /** true: the folder has more files than entries */
      "more"?: boolean;
      /** number of the current entry, from 0 [count] */
      "index"?: number;
      /** times that the slideshow has begun to load an entry [count] */
      "turn"?: number;
      /** true: the entries are shown in turn */
      "playing"?: boolean;
      /** true: the time of the current entry is stopped */
      "paused"?: boolean;
      /** true: starts again after the last entry */
      "loop"?: boolean;
      /** default time of an entry; a video plays once through [seconds] */
      "seconds"?: number;
      /** time in which an image turns into the next one [seconds] */
      "crossfade"?: number;
    };
  };
  /** start the slideshow, or go to an entry */
  "playlist.play": {
    params: {
      /** entry to begin with, from 0 (where it stopped; after its end the first) [count] */
      "index"?: number;
    };
    result: {
      /** what is shown, in this order */
      "entries"?: {
        /** path of the file */
        "file"?: string;
        /** time from the first frame that is shown; absent: not given [seconds] */
        "seconds"?: number;
        /** tiles COLUMNSxROWS; absent: not given */
        "quilt"?: string;
        /** as of scene.load; this and all below absent: not given [degrees] */
        "yaw"?: number;
        /** as of scene.load [degrees] */
        "pitch"?: number;
        /** as of scene.load */
        "up"?: string;
        /** as of scene.load */
        "bare"?: boolean;
        /** as of scene.load */
        "photo"?: string;
        /** as of scene.load */
        "photo_position"?: string;
        /** as of scene.load */
        "photo_rotate"?: string;
        /** as of scene.load [width over height] */
        "aspect"?: number;
        /** as of scene.load [count] */
        "views"?: number;
        /** as of scene.load */
        "rgbd_in"?: string;
        /** as of scene.load */
        "depth_inversion"?: string;
        /** as of scene.load */
        "chroma_depth"?: string;
        /** as of scene.load [factor] */
        "depthiness"?: number;
        /** as of scene.load [code] */
        "depth_cutoff"?: number;
        /** as of scene.load [widths] */
        "focus"?: number;
        /** as of scene.load [factor] */
        "zoom"?: number;
        /** as of scene.load [half widths] */
        "crop_x"?: number;
        /** as of scene.load [half heights] */
        "crop_y"?: number;
      }[];
      /** folder that the entries are from; null: none */
      "folder"?: string | null;
      /** true: the folder has more files than entries */
      "more"?: boolean;
      /** number of the current entry, from 0 [count] */
      "index"?: number;
      /** times that the slideshow has begun to load an entry [count] */
      "turn"?: number;
      /** true: the entries are shown in turn */
      "playing"?: boolean;
      /** true: the time of the current entry is stopped */
      "paused"?: boolean;
      /** true: starts again after the last entry */
      "loop"?: boolean;
      /** default time of an entry; a video plays once through [seconds] */
      "seconds"?: number;
      /** time in which an image turns into the next one [seconds] */
      "crossfade"?: number;
    };
  };
  /** stop the slideshow at the current entry */
  "playlist.stop": {
    params: {};
    result: {
      /** what is shown, in this order */
      "entries"?: {
        /** path of the file */
        "file"?: string;
        /** time from the first frame that is shown; absent: not given [seconds] */
        "seconds"?: number;
        /** tiles COLUMNSxROWS; absent: not given */
        "quilt"?: string;
        /** as of scene.load; this and all below absent: not given [degrees] */
        "yaw"?: number;
        /** as of scene.load [degrees] */
        "pitch"?: number;
        /** as of scene.load */
        "up"?: string;
        /** as of scene.load */
        "bare"?: boolean;
        /** as of scene.load */
        "photo"?: string;
        /** as of scene.load */
        "photo_position"?: string;
        /** as of scene.load */
        "photo_rotate"?: string;
        /** as of scene.load [width over height] */
        "aspect"?: number;
        /** as of scene.load [count] */
        "views"?: number;
        /** as of scene.load */
        "rgbd_in"?: string;
        /** as of scene.load */
        "depth_inversion"?: string;
        /** as of scene.load */
        "chroma_depth"?: string;
        /** as of scene.load [factor] */
        "depthiness"?: number;
        /** as of scene.load [code] */
        "depth_cutoff"?: number;
        /** as of scene.load [widths] */
        "focus"?: number;
        /** as of scene.load [factor] */
        "zoom"?: number;
        /** as of scene.load [half widths] */
        "crop_x"?: number;
        /** as of scene.load [half heights] */
        "crop_y"?: number;
      }[];
      /** folder that the entries are from; null: none */
      "folder"?: string | null;
      /** true: the folder has more files than entries */
      "more"?: boolean;
      /** number of the current entry, from 0 [count] */
      "index"?: number;
      /** times that the slideshow has begun to load an entry [count] */
      "turn"?: number;
      /** true: the entries are shown in turn */
      "playing"?: boolean;
      /** true: the time of the current entry is stopped */
      "paused"?: boolean;
      /** true: starts again after the last entry */
      "loop"?: boolean;
      /** default time of an entry; a video plays once through [seconds] */
      "seconds"?: number;
      /** time in which an image turns into the next one [seconds] */
      "crossfade"?: number;
    };
  };
  /** pause the slideshow, or let it go on */
  "playlist.pause": {
    params: {
      /** true: the entry stays, and a video holds its frame; false: its time goes on */
      "paused"?: boolean;
    };
    result: {
      /** what is shown, in this order */
      "entries"?: {
        /** path of the file */
        "file"?: string;
        /** time from the first frame that is shown; absent: not given [seconds] */
        "seconds"?: number;
        /** tiles COLUMNSxROWS; absent: not given */
        "quilt"?: string;
        /** as of scene.load; this and all below absent: not given [degrees] */
        "yaw"?: number;
        /** as of scene.load [degrees] */
        "pitch"?: number;
        /** as of scene.load */
        "up"?: string;
        /** as of scene.load */
        "bare"?: boolean;
        /** as of scene.load */
        "photo"?: string;
        /** as of scene.load */
        "photo_position"?: string;
        /** as of scene.load */
        "photo_rotate"?: string;
        /** as of scene.load [width over height] */
        "aspect"?: number;
        /** as of scene.load [count] */
        "views"?: number;
        /** as of scene.load */
        "rgbd_in"?: string;
        /** as of scene.load */
        "depth_inversion"?: string;
        /** as of scene.load */
        "chroma_depth"?: string;
        /** as of scene.load [factor] */
        "depthiness"?: number;
        /** as of scene.load [code] */
        "depth_cutoff"?: number;
        /** as of scene.load [widths] */
        "focus"?: number;
        /** as of scene.load [factor] */
        "zoom"?: number;
        /** as of scene.load [half widths] */
        "crop_x"?: number;
        /** as of scene.load [half heights] */
        "crop_y"?: number;
      }[];
      /** folder that the entries are from; null: none */
      "folder"?: string | null;
      /** true: the folder has more files than entries */
      "more"?: boolean;
      /** number of the current entry, from 0 [count] */
      "index"?: number;
      /** times that the slideshow has begun to load an entry [count] */
      "turn"?: number;
      /** true: the entries are shown in turn */
      "playing"?: boolean;
      /** true: the time of the current entry is stopped */
      "paused"?: boolean;
      /** true: starts again after the last entry */
      "loop"?: boolean;
      /** default time of an entry; a video plays once through [seconds] */
      "seconds"?: number;
      /** time in which an image turns into the next one [seconds] */
      "crossfade"?: number;
    };
  };
  /** change keys of an entry of the slideshow */
  "playlist.change": {
    params: {
      /** entry to change, from 0 (the current one) [count] */
      "index"?: number;
      /** time from the first frame that is shown (a video once through; others the list's) [seconds] */
      "seconds"?: number;
      /** tiles COLUMNSxROWS of an image or video whose name has no _qs suffix */
      "quilt"?: string;
      /** file without a scene: how far the eye is to the right of the front (as on the command line, else 22) [degrees] */
      "yaw"?: number;
      /** file without a scene: how far the eye is above the front (as on the command line, else 13) [degrees] */
      "pitch"?: number;
      /** file without a scene: its up axis; file: z in STL files, else y */
      "up"?: "file" | "y" | "z";
      /** file without a scene: dark backdrop, no ground, no studio; of a volume the density grid alone */
      "bare"?: boolean;
      /** image of another shape: show it whole with borders, or cut it to cover the view */
      "photo"?: "fit" | "fill";
      /** position of the image, or the part of it that is kept */
      "photo_position"?: "center" | "left" | "right" | "top" | "bottom" | "top-left" | "top-right" | "bottom-left" | "bottom-right";
      /** turn each image clockwise; auto: by 90 if only one of image and output is upright */
      "photo_rotate"?: "0" | "90" | "180" | "270" | "auto";
      /** width / height of the views of a finished quilt or folder (from its name, images or pixels) */
      "aspect"?: number;
      /** number of views of a quilt image or video; further tiles are unused (all tiles) */
      "views"?: number;
      /** where the depth of an RGBD image is; auto: right if the name ends with _rgbd */
      "rgbd_in"?: "auto" | "off" | "right" | "left" | "top" | "bottom";
      /** on: near is black, far white, in the depth of an RGBD image */
      "depth_inversion"?: "off" | "on";
      /** on: the depth of an RGBD image is a hue, from red, near, to blue, far */
      "chroma_depth"?: "off" | "on";
      /** factor of the depth of an RGBD image */
      "depthiness"?: number;
      /** least depth code of an RGBD image; farther points come up to it */
      "depth_cutoff"?: number;
      /** shift of a finished image: view i of N moves to the right by (2 i/(N-1) - 1) F of its width; above 0 it moves behind the glass */
      "focus"?: number;
      /** scale of a finished image about the middle of the view */
      "zoom"?: number;
      /** part of a finished image in the middle of the view: half widths to the right */
      "crop_x"?: number;
      /** part of a finished image in the middle of the view: half heights down */
      "crop_y"?: number;
    };
    result: {
      /** what is shown, in this order */
      "entries"?: {
        /** path of the file */
        "file"?: string;
        /** time from the first frame that is shown; absent: not given [seconds] */
        "seconds"?: number;
        /** tiles COLUMNSxROWS; absent: not given */
        "quilt"?: string;
        /** as of scene.load; this and all below absent: not given [degrees] */
        "yaw"?: number;
        /** as of scene.load [degrees] */
        "pitch"?: number;
        /** as of scene.load */
        "up"?: string;
        /** as of scene.load */
        "bare"?: boolean;
        /** as of scene.load */
        "photo"?: string;
        /** as of scene.load */
        "photo_position"?: string;
        /** as of scene.load */
        "photo_rotate"?: string;
        /** as of scene.load [width over height] */
        "aspect"?: number;
        /** as of scene.load [count] */
        "views"?: number;
        /** as of scene.load */
        "rgbd_in"?: string;
        /** as of scene.load */
        "depth_inversion"?: string;
        /** as of scene.load */
        "chroma_depth"?: string;
        /** as of scene.load [factor] */
        "depthiness"?: number;
        /** as of scene.load [code] */
        "depth_cutoff"?: number;
        /** as of scene.load [widths] */
        "focus"?: number;
        /** as of scene.load [factor] */
        "zoom"?: number;
        /** as of scene.load [half widths] */
        "crop_x"?: number;
        /** as of scene.load [half heights] */
        "crop_y"?: number;
      }[];
      /** folder that the entries are from; null: none */
      "folder"?: string | null;
      /** true: the folder has more files than entries */
      "more"?: boolean;
      /** number of the current entry, from 0 [count] */
      "index"?: number;
      /** times that the slideshow has begun to load an entry [count] */
      "turn"?: number;
      /** true: the entries are shown in turn */
      "playing"?: boolean;
      /** true: the time of the current entry is stopped */
      "paused"?: boolean;
      /** true: starts again after the last entry */
      "loop"?: boolean;
      /** default time of an entry; a video plays once through [seconds] */
      "seconds"?: number;
      /** time in which an image turns into the next one [seconds] */
      "crossfade"?: number;
    };
  };
  /** show the next entry of the slideshow */
  "playlist.next": {
    params: {};
    result: {
      /** what is shown, in this order */
      "entries"?: {
        /** path of the file */
        "file"?: string;
        /** time from the first frame that is shown; absent: not given [seconds] */
        "seconds"?: number;
        /** tiles COLUMNSxROWS; absent: not given */
        "quilt"?: string;
        /** as of scene.load; this and all below absent: not given [degrees] */
        "yaw"?: number;
        /** as of scene.load [degrees] */
        "pitch"?: number;
        /** as of scene.load */
        "up"?: string;
        /** as of scene.load */
        "bare"?: boolean;
        /** as of scene.load */
        "photo"?: string;
        /** as of scene.load */
        "photo_position"?: string;
        /** as of scene.load */
        "photo_rotate"?: string;
        /** as of scene.load [width over height] */
        "aspect"?: number;
        /** as of scene.load [count] */
        "views"?: number;
        /** as of scene.load */
        "rgbd_in"?: string;
        /** as of scene.load */
        "depth_inversion"?: string;
        /** as of scene.load */
        "chroma_depth"?: string;
        /** as of scene.load [factor] */
        "depthiness"?: number;
        /** as of scene.load [code] */
        "depth_cutoff"?: number;
        /** as of scene.load [widths] */
        "focus"?: number;
        /** as of scene.load [factor] */
        "zoom"?: number;
        /** as of scene.load [half widths] */
        "crop_x"?: number;
        /** as of scene.load [half heights] */
        "crop_y"?: number;
      }[];
      /** folder that the entries are from; null: none */
      "folder"?: string | null;
      /** true: the folder has more files than entries */
      "more"?: boolean;
      /** number of the current entry, from 0 [count] */
      "index"?: number;
      /** times that the slideshow has begun to load an entry [count] */
      "turn"?: number;
      /** true: the entries are shown in turn */
      "playing"?: boolean;
      /** true: the time of the current entry is stopped */
      "paused"?: boolean;
      /** true: starts again after the last entry */
      "loop"?: boolean;
      /** default time of an entry; a video plays once through [seconds] */
      "seconds"?: number;
      /** time in which an image turns into the next one [seconds] */
      "crossfade"?: number;
    };
  };
  /** show the previous entry of the slideshow */
  "playlist.previous": {
    params: {};
    result: {
      /** what is shown, in this order */
      "entries"?: {
        /** path of the file */
        "file"?: string;
        /** time from the first frame that is shown; absent: not given [seconds] */
        "seconds"?: number;
        /** tiles COLUMNSxROWS; absent: not given */
        "quilt"?: string;
        /** as of scene.load; this and all below absent: not given [degrees] */
        "yaw"?: number;
        /** as of scene.load [degrees] */
        "pitch"?: number;
        /** as of scene.load */
        "up"?: string;
        /** as of scene.load */
        "bare"?: boolean;
        /** as of scene.load */
        "photo"?: string;
        /** as of scene.load */
        "photo_position"?: string;
        /** as of scene.load */
        "photo_rotate"?: string;
        /** as of scene.load [width over height] */
        "aspect"?: number;
        /** as of scene.load [count] */
        "views"?: number;
        /** as of scene.load */
        "rgbd_in"?: string;
        /** as of scene.load */
        "depth_inversion"?: string;
        /** as of scene.load */
        "chroma_depth"?: string;
        /** as of scene.load [factor] */
        "depthiness"?: number;
        /** as of scene.load [code] */
        "depth_cutoff"?: number;
        /** as of scene.load [widths] */
        "focus"?: number;
        /** as of scene.load [factor] */
        "zoom"?: number;
        /** as of scene.load [half widths] */
        "crop_x"?: number;
        /** as of scene.load [half heights] */
        "crop_y"?: number;
      }[];
      /** folder that the entries are from; null: none */
      "folder"?: string | null;
      /** true: the folder has more files than entries */
      "more"?: boolean;
      /** number of the current entry, from 0 [count] */
      "index"?: number;
      /** times that the slideshow has begun to load an entry [count] */
      "turn"?: number;
      /** true: the entries are shown in turn */
      "playing"?: boolean;
      /** true: the time of the current entry is stopped */
      "paused"?: boolean;
      /** true: starts again after the last entry */
      "loop"?: boolean;
      /** default time of an entry; a video plays once through [seconds] */
      "seconds"?: number;
      /** time in which an image turns into the next one [seconds] */
      "crossfade"?: number;
    };
  };
  /** wait until the panel shows the image */
  "wait": {
    params: {
      /** wait for this generation or a later one (the newest) [count] */
      "generation"?: number;
      /** level that the panel must show */
      "for"?: "coarse" | "complete" | "converged";
      /** fail with -32004 after this time (never) [seconds] */
      "timeout"?: number;
    };
    result: {
      /** generation of the scene on the panel [count] */
      "generation"?: number;
      /** coarse, complete or converged */
      "level"?: string;
    };
  };
  /** set how to render; other settings keep their values */
  "render.set": {
    params: {
      /** stop rendering, or hold the frame of a video, or continue */
      "paused"?: boolean;
      /** how views share light paths; another one starts the image again */
      "integrator"?: "mvpt" | "vpt" | "amvpt";
      /** how samples become the image; mwis has the least noise, mis and cv are unbiased */
      "estimator"?: "mwis" | "mis" | "cv";
      /** no effect in quiltd */
      "png"?: boolean;
      /** tint what is too near (red) or too far (blue) for the panel to show sharply */
      "guides"?: boolean;
      /** worker threads; 0: all CPUs; another number starts the image again [threads] */
      "threads"?: number;
      /** stops; auto: measured; scene: the scene's own */
      "exposure"?: "auto" | "scene" | number;
      /** rendering rests when the bound of the error is below this relative mean squared error */
      "target_error"?: number;
      /** show the denoised image; auto: if the estimator is mwis */
      "denoise"?: "auto" | "off" | "on";
    };
    result: {
      /** generation of the image; a new one if the image restarts [count] */
      "generation"?: number;
    };
  };
  /** write the image that is shown, as a quilt, to a passed descriptor */
  "frame.get": {
    params: {
      /** number of views, evenly spaced; 1: the middle one (all) */
      "views"?: number;
      /** width of a view, at most as rendered; the height follows (as rendered) [pixels] */
      "width"?: number;
      /** raw: RGB, 3 bytes per pixel, rows from the top */
      "format"?: "jpeg" | "raw";
      /** quality of the JPEG */
      "quality"?: number;
    };
    result: {
      /** number of the scene and camera state [count] */
      "generation"?: number;
      /** none, coarse, complete or converged */
      "level"?: string;
      /** passes in the image [passes] */
      "passes"?: number;
      /** denoised or unfiltered */
      "image"?: string;
      /** jpeg or raw */
      "format"?: string;
      /** columns of the quilt [tiles] */
      "columns"?: number;
      /** rows of the quilt [tiles] */
      "rows"?: number;
      /** number of views [count] */
      "views"?: number;
      /** width of one view [pixels] */
      "width"?: number;
      /** height of one view [pixels] */
      "height"?: number;
      /** size of the written file [bytes] */
      "bytes"?: number;
    };
  };
  /** list a readable folder: scenes, models, volumes, images and folders */
  "library.list": {
    params: {
      /** folder to list (the folders that quiltd may read) */
      "folder"?: string;
    };
    result: {
      /** folder that is listed; null: none */
      "folder"?: string | null;
      /** folders that may be read by name */
      "folders"?: string[];
      /** what is in the folder, folders first */
      "entries"?: {
        /** name without the folder */
        "name"?: string;
        /** absolute path, for scene.load */
        "path"?: string;
        /** folder, scene, model, volume, environment, quilt, video or image */
        "kind"?: string;
        /** size of the file; 0: a folder [bytes] */
        "bytes"?: number;
        /** time of the last change since 1970 (UTC) [seconds] */
        "modified"?: number;
      }[];
      /** true: further entries are left out */
      "more"?: boolean;
    };
  };
  /** write a small JPEG of an image file to a passed descriptor */
  "library.thumbnail": {
    params: {
      /** image or quilt; of a quilt the middle view */
      "file": string;
      /** width of the JPEG, at most the width of the image; the height follows [pixels] */
      "width"?: number;
    };
    result: {
      /** width of the JPEG [pixels] */
      "width"?: number;
      /** height of the JPEG [pixels] */
      "height"?: number;
      /** size of the written file [bytes] */
      "bytes"?: number;
    };
  };
  /** write a quilt, views, panel image, print, pitch test chart or state */
  "export": {
    params: {
      /** kind of output, see Export kinds */
      "kind": "quilt" | "still" | "views" | "pictures" | "panel" | "print" | "chart" | "proof" | "rgbd" | "state";
      /** name of the file, or of a folder with a final slash, below --export-dir; with fds any name: only its ending counts */
      "file": string;
      /** write as soon as the image has this level; state: at once */
      "wait"?: "coarse" | "complete" | "converged";
      /** continue after the client disconnects */
      "detach"?: boolean;
      /** replace an existing file */
      "overwrite"?: boolean;
      /** write the denoised image; auto: as on the panel, but EXR files unfiltered */
      "denoise"?: "auto" | "off" | "on";
      /** farm that renders the scene again, see Farms; quiltd needs --farm */
      "farm"?: "slurm" | "parallel" | "list";
      /** farm: new folder below --export-dir, for scene, tasks and states of the job */
      "job"?: string;
      /** farm: base paths per view pixel (as quiltrender) [samples per pixel] */
      "spp"?: number;
      /** farm: base paths per pixel of one view (as quiltrender) [passes] */
      "passes"?: number;
      /** number of descriptors (SCM_RIGHTS) that come with the call; quiltd writes to them instead of opening file */
      "fds"?: number;
      /** print: measured visual pitch of the lens sheet; chart: pitch in its middle [lpi] */
      "lpi"?: number;
      /** resolution of the printer; "XxY": across and down the page [dpi] */
      "dpi"?: string | number;
      /** chart: how far its pitches go below and above the middle [lpi] */
      "range"?: number;
      /** chart: difference of pitch between two bands [lpi] */
      "step"?: number;
      /** trim width of the print [mm] */
      "width"?: number;
      /** trim height of the print [mm] */
      "height"?: number;
      /** views under a lens (the whole part of 0.8 dpi / lpi, at least 2) */
      "views"?: number;
      /** how stripes of views are mapped to printer dots */
      "stripes"?: "fractional" | "nearest";
      /** move the lens in the middle of the print to the right [mm] */
      "phase"?: number;
      /** orientation of the lenses */
      "orientation"?: "vertical" | "horizontal";
      /** angle of the lenses, clockwise: the top of a vertical lens leans right [degrees] */
      "slant"?: number;
      /** rows of lenses, or a micro lens sheet with views in both axes */
      "lens_grid"?: "linear" | "square" | "hexagonal";
      /** micro lens sheets: rows of views (as many as columns) */
      "view_rows"?: number;
      /** micro lens sheets: move the lens in the middle down [mm] */
      "phase_down"?: number;
      /** pitch over the sheet; auto: exact if thickness and distance are given */
      "map"?: "auto" | "uniform" | "exact";
      /** thickness of the lens sheet (unknown) [mm] */
      "thickness"?: number;
      /** refractive index of the lens sheet (1.56) */
      "index"?: number;
      /** radius of the lens surface (unknown) [mm] */
      "radius"?: number;
      /** viewing angle of the lens sheet, as its maker says (unknown) [degrees] */
      "viewing_angle"?: number;
      /** viewing distance for which LPI was measured (unknown) [mm] */
      "distance"?: number;
      /** rendered margin on every side [mm] */
      "bleed"?: number;
      /** ICC file with the colour profile of the print, in a readable folder (sRGB) */
      "icc"?: string;
      /** bits per channel */
      "bits"?: 8 | 16 | number;
      /** compression of the TIFF file */
      "compress"?: "none" | "lzw" | "deflate";
      /** order the views under a lens from first to last */
      "reverse"?: boolean;
      /** mirror the whole print, for the back of the sheet */
      "mirror"?: boolean;
      /** add register and alignment marks, 8 mm more on every side */
      "marks"?: boolean;
      /** copies of the print side by side, for one lens sheet (1) */
      "columns"?: number;
      /** copies of the print one below another (1) */
      "rows"?: number;
      /** least distance between two copies, outside their bleed [mm] */
      "gutter"?: number;
      /** width of the page on which the prints are centred (as large as they need) [mm] */
      "paper_width"?: number;
      /** height of the page on which the prints are centred (as large as they need) [mm] */
      "paper_height"?: number;
      /** text below each print, outside trim and bleed */
      "label"?: string;
      /** height of the label's capital letters (2.5) [mm] */
      "label_size"?: number;
      /** stripes between two images of a flip, which keep them apart */
      "guard"?: number;
      /** what guard stripes show: the image next to them, or paper white or black */
      "guard_kind"?: "repeat" | "white" | "black";
      /** frames that blend each image into the next one */
      "morph"?: number;
      /** width of the spot that a lens images onto the print [mm] */
      "spot"?: number;
      /** dot gain of the printer at 50 % */
      "dot_gain"?: number;
      /** standard deviation of the spread of ink [mm] */
      "ink_spread"?: number;
      /** take back crosstalk and dot gain, as far as ink and paper allow */
      "compensate"?: "off" | "on";
      /** compensation: linear light taken from black and from white for it */
      "headroom"?: number;
      /** panel: how its pixels are taken from the views; nearest copies 8-bit values unchanged */
      "filter"?: "nearest" | "linear";
      /** panel: reverse the order of the views under a lens; auto: as the calibration says */
      "invert"?: "auto" | "yes" | "no";
      /** profile of the lens sheet, by name or file (quiltprint list) */
      "lens"?: string;
      /** profile of the printer, by name or file */
      "printer"?: string;
      /** response of the panel to its codes: srgb or an exponent */
      "gamma"?: "srgb" | number;
      /** colour temperature of the panel's white; not together with white_x [kelvin] */
      "white"?: number;
      /** CIE x of the panel's white; needs white_y */
      "white_x"?: number;
      /** CIE y of the panel's white; needs white_x */
      "white_y"?: number;
      /** rgbd: side on which the depth is */
      "side"?: "right" | "left" | "top" | "bottom";
      /** rgbd: the middle view, or all views as a quilt next to a quilt of depth */
      "of"?: "middle" | "quilt";
      /** rgbd: on: near is black and far is white in the depth */
      "depth_inversion"?: "off" | "on";
      /** rgbd: distance along the view axis of the nearest depth code (from the image) [scene units] */
      "near"?: number;
      /** rgbd: distance along the view axis of the farthest depth code (from the image) [scene units] */
      "far"?: number;
      /** image of another shape: show it whole with borders, or cut it to cover the view */
      "photo"?: "fit" | "fill";
      /** position of the image, or the part of it that is kept */
      "photo_position"?: "center" | "left" | "right" | "top" | "bottom" | "top-left" | "top-right" | "bottom-left" | "bottom-right";
    };
    result: {
      /** job number of the export; a notification reports its end [count] */
      "job"?: number;
      /** file to be written; with fds the name of the call */
      "file"?: string;
      /** print: whether the scene is too deep for the sheet */
      "warnings"?: string[];
    };
  };
  /** cancel an export or a load */
  "job.cancel": {
    params: {
      /** number of the export or load, from its answer or from status [count] */
      "job": number;
    };
    result: {};
  };
  /** list the devices that can be opened */
  "device.list": {
    params: {};
    result: {
      /** devices that can be opened */
      "devices"?: ({
        /** device spec for --device and device.set */
        "spec"?: string;
        /** kind of device, such as sim or none */
        "kind"?: string;
        /** name of the display, if it has one */
        "model"?: string;
        /** serial number of the panel */
        "serial"?: string;
        /** where the calibration came from */
        "calibration_from"?: string;
        /** file, connector or USB address */
        "output"?: string;
        /** what is wrong and what to do; empty if all is well */
        "problem"?: string;
        /** true: the device is open; absent in lists */
        "present"?: boolean;
        /** response of the panel; absent in lists */
        "response"?: {
          /** gamma: a number or srgb [exponent] */
          "gamma"?: number | string;
          /** colour temperature of the white; 0: not set [kelvin] */
          "white"?: number;
          /** chromaticity of the white; 0: not set [CIE x] */
          "white_x"?: number;
          /** chromaticity of the white; 0: not set [CIE y] */
          "white_y"?: number;
        };
      })[];
      /** device that is open */
      "present"?: {
        /** device spec for --device and device.set */
        "spec"?: string;
        /** kind of device, such as sim or none */
        "kind"?: string;
        /** name of the display, if it has one */
        "model"?: string;
        /** serial number of the panel */
        "serial"?: string;
        /** where the calibration came from */
        "calibration_from"?: string;
        /** file, connector or USB address */
        "output"?: string;
        /** what is wrong and what to do; empty if all is well */
        "problem"?: string;
        /** true: the device is open; absent in lists */
        "present"?: boolean;
        /** response of the panel; absent in lists */
        "response"?: {
          /** gamma: a number or srgb [exponent] */
          "gamma"?: number | string;
          /** colour temperature of the white; 0: not set [kelvin] */
          "white"?: number;
          /** chromaticity of the white; 0: not set [CIE x] */
          "white_x"?: number;
          /** chromaticity of the white; 0: not set [CIE y] */
          "white_y"?: number;
        };
      };
    };
  };
  /** open another device and set the panel's response */
  "device.set": {
    params: {
      /** device as in --device: auto, none, sim:DIR, drm, window, usb */
      "spec": string;
      /** with spec none: when this connection ends, open the panel again */
      "lend"?: boolean;
      /** response of the panel to its codes: srgb or an exponent */
      "gamma"?: "srgb" | number;
      /** colour temperature of the panel's white; not together with white_x [kelvin] */
      "white"?: number;
      /** CIE x of the panel's white; needs white_y */
      "white_x"?: number;
      /** CIE y of the panel's white; needs white_x */
      "white_y"?: number;
    };
    result: {
      /** device spec for --device and device.set */
      "spec"?: string;
      /** kind of device, such as sim or none */
      "kind"?: string;
      /** name of the display, if it has one */
      "model"?: string;
      /** serial number of the panel */
      "serial"?: string;
      /** where the calibration came from */
      "calibration_from"?: string;
      /** file, connector or USB address */
      "output"?: string;
      /** what is wrong and what to do; empty if all is well */
      "problem"?: string;
      /** true: the device is open; absent in lists */
      "present"?: boolean;
      /** response of the panel; absent in lists */
      "response"?: {
        /** gamma: a number or srgb [exponent] */
        "gamma"?: number | string;
        /** colour temperature of the white; 0: not set [kelvin] */
        "white"?: number;
        /** chromaticity of the white; 0: not set [CIE x] */
        "white_x"?: number;
        /** chromaticity of the white; 0: not set [CIE y] */
        "white_y"?: number;
      };
    };
  };
  /** return the lens calibration of the panel */
  "device.calibration": {
    params: {};
    result: {
      /** version of the calibration format */
      "configVersion"?: string;
      /** serial number of the panel */
      "serial"?: string;
      /** pitch of the lenses [lenses per inch] */
      "pitch"?: number;
      /** slant of the lenses [rise over run] */
      "slope"?: number;
      /** phase of the lenses [lens periods] */
      "center"?: number;
      /** view cone of the optics; 0: not given [degrees] */
      "viewCone"?: number;
      /** resolution of the panel [pixels per inch] */
      "DPI"?: number;
      /** width of the panel [pixels] */
      "screenW"?: number;
      /** height of the panel [pixels] */
      "screenH"?: number;
      /** 1: the order of the views is reversed [count] */
      "invView"?: number;
      /** 1: mirrored horizontally [count] */
      "flipImageX"?: number;
      /** 1: mirrored vertically [count] */
      "flipImageY"?: number;
      /** 1: the subpixel order is blue, green, red [count] */
      "flipSubp"?: number;
      /** number of the subpixel layout [count] */
      "CellPatternMode"?: number;
      /** positions of the subpixels */
      "subpixelCells"?: { [key: string]: unknown }[];
      /** quilt layout of the panel, if given */
      "defaultQuilt"?: {
        /** width of the quilt [pixels] */
        "quiltX"?: number;
        /** height of the quilt [pixels] */
        "quiltY"?: number;
        /** columns of the quilt [tiles] */
        "tileX"?: number;
        /** rows of the quilt [tiles] */
        "tileY"?: number;
      };
    };
  };
  /** check what this machine needs to show an image on a panel */
  "doctor": {
    params: {};
    result: {
      /** what was found, in order */
      "findings"?: {
        /** ok: works; note: may matter; fail: must be fixed */
        "level"?: string;
        /** what was found and what to do, in one line */
        "text"?: string;
      }[];
    };
  };
  /** trigger the action of a panel button */
  "button": {
    params: {
      /** button of a first-generation panel */
      "name": "square" | "left" | "right" | "circle";
    };
    result: {
      /** action of the button, as in --buttons */
      "action"?: string;
    };
  };
  /** return the last lines of the log */
  "log.tail": {
    params: {
      /** number of lines, at most */
      "lines"?: number;
    };
    result: {
      /** lines of the log, oldest first */
      "lines"?: {
        /** number of the line since the daemon started [count] */
        "number"?: number;
        /** time of the line since 1970 (UTC) [seconds] */
        "time"?: number;
        /** error, warning, info or debug */
        "level"?: string;
        /** text of the line, at most 1023 bytes */
        "text"?: string;
      }[];
    };
  };
  /** choose the notifications for this client */
  "subscribe": {
    params: {
      /** events to send; an empty list: none, except the progress of your own exports */
      "events": ("frame" | "converged" | "device" | "scene" | "export" | "button" | "log" | "playlist")[];
    };
    result: {
      /** events that this client now receives */
      "events"?: string[];
    };
  };
  /** allow this connection only these methods from now on */
  "rights.limit": {
    params: {
      /** methods that stay allowed; each must be allowed before */
      "methods": string[];
    };
    result: {
      /** methods that this connection may call now */
      "methods"?: string[];
    };
  };
  /** shut down the daemon */
  "shutdown": {
    params: {};
    result: {};
  };
}

export interface Notifications {
  /** the panel shows a new frame */
  "frame": {
    /** number of the scene and camera state [count] */
    "generation"?: number;
    /** none, coarse, complete or converged */
    "level"?: string;
    /** passes in the image [passes] */
    "passes"?: number;
    /** denoised, unfiltered or card */
    "image"?: string;
    /** former image: reconstructed, unfiltered or card */
    "picture"?: string;
    /** text on the card, if one is shown */
    "card"?: string;
  };
  /** the image has reached the target error */
  "converged": {
    /** number of the scene and camera state [count] */
    "generation"?: number;
    /** passes in the image [passes] */
    "passes"?: number;
  };
  /** the panel was connected, disconnected or changed */
  "device": {
    /** device spec for --device and device.set */
    "spec"?: string;
    /** kind of device, such as sim or none */
    "kind"?: string;
    /** name of the display, if it has one */
    "model"?: string;
    /** serial number of the panel */
    "serial"?: string;
    /** where the calibration came from */
    "calibration_from"?: string;
    /** file, connector or USB address */
    "output"?: string;
    /** what is wrong and what to do; empty if all is well */
    "problem"?: string;
    /** true: the device is open; absent in lists */
    "present"?: boolean;
    /** response of the panel; absent in lists */
    "response"?: {
      /** gamma: a number or srgb [exponent] */
      "gamma"?: number | string;
      /** colour temperature of the white; 0: not set [kelvin] */
      "white"?: number;
      /** chromaticity of the white; 0: not set [CIE x] */
      "white_x"?: number;
      /** chromaticity of the white; 0: not set [CIE y] */
      "white_y"?: number;
    };
  };
  /** the scene was replaced or changed */
  "scene": {
    /** generation of the scene on display [count] */
    "generation"?: number;
    /** file of the scene */
    "file"?: string;
    /** turn of the slideshow that loaded it; absent: loaded otherwise [count] */
    "turn"?: number;
  };
  /** progress of reading a scene file, sent twice per second */
  "scene.load": {
    /** file being read, one of the scene's files */
    "file"?: string;
    /** size of this file [bytes] */
    "bytes"?: number;
    /** time spent on this file so far [seconds] */
    "seconds"?: number;
    /** number of files read before [count] */
    "files_read"?: number;
    /** job number of the load, for job.cancel [count] */
    "job"?: number;
  };
  /** progress and end of an export; the client that started it always receives it */
  "export": {
    /** job number of the export [count] */
    "job"?: number;
    /** kind of the export */
    "kind"?: string;
    /** file being written */
    "file"?: string;
    /** waiting, running, done, failed or cancelled */
    "state"?: string;
    /** share written, or of a farm's tasks that are complete, from 0 to 1 [share] */
    "progress"?: number;
    /** the farm that renders it; absent if quiltd does */
    "farm"?: {
      /** slurm, parallel or list */
      "engine"?: string;
      /** folder of the job, for quiltfarm */
      "folder"?: string;
      /** planning, submitting, planned, queued, running, merging, interrupted, failed or complete */
      "state"?: string;
      /** its tasks */
      "tasks"?: {
        /** all tasks; 0: not known yet [count] */
        "total"?: number;
        /** tasks whose results are there [count] */
        "complete"?: number;
        /** tasks that run [count] */
        "running"?: number;
        /** tasks that have failed [count] */
        "failed"?: number;
        /** tasks that have no result yet [count] */
        "missing"?: number;
      };
      /** CPU time of all tasks */
      "cpu_seconds"?: {
        /** what quiltfarm expects; null: unknown [seconds] */
        "planned"?: number | null;
        /** what was used so far; null: unknown [seconds] */
        "spent"?: number | null;
      };
      /** time to its end; null: unknown [seconds] */
      "seconds_left"?: number | null;
      /** why quiltfarm did not say how far it is; null: it did */
      "problem"?: string | null;
    };
    /** why it failed; absent if it did not */
    "error"?: {
      /** error code, as in an error response [count] */
      "code"?: number;
      /** what is wrong and what to do, in one line */
      "message"?: string;
      /** where the error is, if known */
      "data"?: {
        /** file or option with the error */
        "file"?: string;
        /** line in this file, from 1 [count] */
        "line"?: number;
        /** JSON pointer of the value */
        "pointer"?: string;
      };
    };
    /** print by profiles: what they gave */
    "used"?: string[];
    /** print by profiles: what they lack */
    "warnings"?: string[];
  };
  /** the daemon has logged a line */
  "log": {
    /** number of the line since the daemon started [count] */
    "number"?: number;
    /** time of the line since 1970 (UTC) [seconds] */
    "time"?: number;
    /** error, warning, info or debug */
    "level"?: string;
    /** text of the line, at most 1023 bytes */
    "text"?: string;
  };
  /** the slideshow started, stopped, changed or shows another entry */
  "playlist": {
    /** what is shown, in this order */
    "entries"?: {
      /** path of the file */
      "file"?: string;
      /** time from the first frame that is shown; absent: not given [seconds] */
      "seconds"?: number;
      /** tiles COLUMNSxROWS; absent: not given */
      "quilt"?: string;
      /** as of scene.load; this and all below absent: not given [degrees] */
      "yaw"?: number;
      /** as of scene.load [degrees] */
      "pitch"?: number;
      /** as of scene.load */
      "up"?: string;
      /** as of scene.load */
      "bare"?: boolean;
      /** as of scene.load */
      "photo"?: string;
      /** as of scene.load */
      "photo_position"?: string;
      /** as of scene.load */
      "photo_rotate"?: string;
      /** as of scene.load [width over height] */
      "aspect"?: number;
      /** as of scene.load [count] */
      "views"?: number;
      /** as of scene.load */
      "rgbd_in"?: string;
      /** as of scene.load */
      "depth_inversion"?: string;
      /** as of scene.load */
      "chroma_depth"?: string;
      /** as of scene.load [factor] */
      "depthiness"?: number;
      /** as of scene.load [code] */
      "depth_cutoff"?: number;
      /** as of scene.load [widths] */
      "focus"?: number;
      /** as of scene.load [factor] */
      "zoom"?: number;
      /** as of scene.load [half widths] */
      "crop_x"?: number;
      /** as of scene.load [half heights] */
      "crop_y"?: number;
    }[];
    /** folder that the entries are from; null: none */
    "folder"?: string | null;
    /** true: the folder has more files than entries */
    "more"?: boolean;
    /** number of the current entry, from 0 [count] */
    "index"?: number;
    /** times that the slideshow has begun to load an entry [count] */
    "turn"?: number;
    /** true: the entries are shown in turn */
    "playing"?: boolean;
    /** true: the time of the current entry is stopped */
    "paused"?: boolean;
    /** true: starts again after the last entry */
    "loop"?: boolean;
    /** default time of an entry; a video plays once through [seconds] */
    "seconds"?: number;
    /** time in which an image turns into the next one [seconds] */
    "crossfade"?: number;
  };
  /** a button on the panel was pressed */
  "button": {
    /** square, left, right or circle */
    "button"?: string;
    /** action of the button, as in --buttons */
    "action"?: string;
  };
}

/** A word of subscribe. */
export type EventWord = "frame" | "converged" | "device" | "scene" | "export" | "log" | "playlist" | "button";

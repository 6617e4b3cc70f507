// The enumerations of record fields, one row per value.
#pragma once

#include "cfg/choices.hpp"
#include "fsw/base/enumeration.hpp"
#include "fsw/base/geometry.hpp"
#include "fsw/base/status.hpp"
#include "fsw/base/verdicts.hpp"

namespace ilp {

/// Why a frame's time stamp is suspect.
ILP_ENUMERATION(TimeDoubt, (0, none, "the time is that of the stamp"),
                (1, off_command, "the stamp is far from the commanded time, which is used"),
                (2, off_period, "the stamp is far from the time by the camera's counter and period, which is used"))

ILP_ENUMERATION(CaptureSource, (0, regular, "the interval is constant"),
                (1, forecast, "the forecast overlap reaches its target"),
                (2, on_the_way, "before that, because the error of the forecast is large"),
                (3, safe, "the motion is not known"), (4, telecommand, "the ground asked for this time"),
                (5, burst, "beside another image, to show how a rolling shutter moved"))

ILP_ENUMERATION(CaptureState, (0, pending, "the time has not come yet"), (1, exposed, "a frame answers it"),
                (2, no_frame, "no frame came"), (3, rejected, "the request could not be met"),
                (4, superseded, "another capture has taken its place"))

ILP_ENUMERATION(OverlapDecision, (0, skipped, "its overlap is above the target"), (1, selected, "it is a keyframe"),
                (2, new_strip, "it is the first keyframe of a new strip"),
                (3, rejected, "its overlap could not be measured"),
                (4, burst, "it shows how the camera moved beside another image"))

ILP_ENUMERATION(StripEnd, (0, open, "still open"), (1, overlap_lost, "overlap lost"),
                (2, overlap_unknown, "overlap unknown"), (3, pose_lost, "pose lost"),
                (4, end_of_flight, "end of flight"), (5, commanded, "ended by command"))

ILP_ENUMERATION(CameraSource, (0, given, "known before the flight"),
                (1, nominal, "from a data sheet or a field of view"),
                (2, calibrated, "found from images of the flight"),
                (3, measured, "found from images and the vehicle's measurements"))

ILP_ENUMERATION(MotionSource, (0, none, "not known: the image stays as it was read"),
                (1, frames, "the frames about the keyframe"))

ILP_ENUMERATION(ScaleSource, (0, first_baseline, "the first baseline is one unit"),
                (1, altimeter, "the altimeter gives metres"),
                (2, navigation, "the vehicle's navigation gives metres: set on the ground"))

/// Levels of reduced work (fsw/shared/work_level.hpp).
ILP_ENUMERATION(ReducedWork, (0, full, ""), (1, fewer_features, "fewer features"),
                (2, coarser_stereo, "fewer features and coarser stereo"))

/// Verdict on the pose of a keyframe: the SequenceVerdict, or `ambiguous` if the strip ended before a view decided
/// between two motions over a plane. The number 6 is retired.
ILP_ENUMERATION(PoseVerdict, (0, ok, ""), (1, waiting, "waits for a pair that can begin"),
                (2, too_few_matches, "too few matches"), (3, two_view_failed, "pair gives no pose"),
                (4, resection_failed, "resection failed"), (5, implausible, "implausible step"),
                (7, ambiguous, "two motions explain the pair"))

ILP_ENUMERATION(PoseState, (0, provisional, "later keyframes may improve it"),
                (1, final, "the pose never changes again"), (2, failed, "there is no pose"),
                (3, trial, "by a camera still looked for: posed again once it is found"),
                (4, trial_failed, "that camera gives no pose: tried again once it is found"))

/// Whether the pose may still change.
[[nodiscard]] constexpr bool is_open(PoseState state) {
  return state != PoseState::final && state != PoseState::failed;
}

/// The extent within which the ground of a mask is new.
ILP_ENUMERATION(MaskScope, (0, strip, "new to the strip; the memory of places has still to see it"),
                (1, flight, "new to the whole flight: the mask is final"))

ILP_ENUMERATION(DepthVerdict, (0, ok, ""), (1, no_partner, "no stereo partner"),
                (2, rectification_impossible, "not rectifiable"), (3, too_few_valid, "too few valid depths"))

/// Products in the order in which they are made: a keyframe's depth map, if there is one, is made before its image.
ILP_ENUMERATION(ProductKind, (0, depth, ""), (1, image, ""))

ILP_ENUMERATION(ProductScheme, (0, lossy_region, "lossy, region first"), (1, lossless_region, "lossless region"),
                (2, thumbnail, ""))

ILP_ENUMERATION(ProductState, (0, stored, "part of it has not been handed to the link"),
                (1, sent, "all of it has been handed to the link"), (2, acknowledged, "the ground holds all of it"),
                (3, dropped, "it was abandoned"))

ILP_ENUMERATION(DownlinkKind, (0, product, "layers of a product"), (1, records, "records of keyframes or events"),
                (2, points, "sparse points"))

ILP_ENUMERATION(CommandKind, (0, end_strip, "the open strip ends"),
                (1, capture, "an image is taken at a time that is not past"),
                (2, refine, "the products of a keyframe are sent before others"),
                (3, capture_soon, "an image is taken at a time, or at once if the time is past"),
                (4, delete_product, "the ground abandons a product"),
                (5, restart, "a component goes back to its checkpoint"),
                (6, report_enable, "a periodic housekeeping report is enabled"),
                (7, report_disable, "a periodic housekeeping report is disabled"),
                (8, report_once, "a housekeeping report is sent now"),
                (9, report_interval, "the interval of a housekeeping report is set"),
                (10, event_enable, "the reports of an event are enabled"),
                (11, event_disable, "the reports of an event are disabled"),
                (12, events_report, "the events whose reports are disabled are listed"),
                (13, capture_place, "an image is taken where the vehicle passes a place"))

ILP_ENUMERATION(TransferState, (0, waiting, "nothing of it has been sent"), (1, sending, "part of it has been sent"),
                (2, sent, "all of it has been sent once; gaps are sent again"),
                (3, delivered, "the ground has confirmed the complete file"))

/// The ground's request for a transfer.
ILP_ENUMERATION(TransferWish, (0, none, ""), (1, suspend, ""), (2, resume, ""), (3, cancel, ""))

ILP_ENUMERATION(UplinkState, (0, checked, "it can be activated"), (1, rejected, "its content is not accepted"),
                (2, active, "its parameters were set"), (3, superseded, "another file has taken its place"))

/// Verdict on a link, which is ground that two keyframes have in common.
ILP_ENUMERATION(LinkVerdict, (0, linked, "the images and the geometry agree"),
                (1, images_only, "the images agree; too few matches have depth for the geometry"),
                (2, contradicts_poses, "images and geometry agree, but the poses of the strip do not: drift"))

/// Whether a fix on the map is used for the strip.
ILP_ENUMERATION(FixState, (0, none, "there is no fix"), (1, accepted, "it counts"),
                (2, unconfirmed, "farther from the prior than that errs: it counts if the next one agrees"))

/// The source of a keyframe's approximate position on the map, before its registration.
ILP_ENUMERATION(FixPrior, (0, none, "nothing: it was not searched for"), (1, vehicle, "the vehicle's measurements"),
                (2, fixes, "the latest fixes and the poses since"),
                (3, search, "a comparison with the features of all tiles"))

/// The reason for the start of the software.
ILP_ENUMERATION(StartReason, (0, first, "the store is new"), (1, stopped, "the boot before ended in order"),
                (2, process_died, "the process was killed or crashed, and the board went on"),
                (3, board_reset, "power was lost, or the board was reset"),
                (4, watchdog, "the watchdog reset the board"))

/// The parameters with which a boot begins (docs/getting-back-in.md).
ILP_ENUMERATION(ConfigurationStage, (0, as_set, "the parameters as they were set"),
                (1, last_good, "the last good configuration"), (2, built_in, "the built-in defaults"))

}  // namespace ilp

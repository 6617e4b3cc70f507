// The enumerations of record fields, one row per value.
#pragma once

#include "cfg/choices.hpp"
#include "fsw/base/enumeration.hpp"
#include "fsw/base/status.hpp"
#include "fsw/base/verdicts.hpp"

namespace ilp {

/// The reason to doubt a frame's time stamp.
ILP_ENUMERATION(TimeDoubt, (0, none, "the time is as stamped"),
                (1, off_command, "the stamp is far from the commanded time, which is used"),
                (2, off_period, "the stamp is far from where the camera's counter and period put it, which is used"))

ILP_ENUMERATION(CaptureSource, (0, regular, "a constant interval"),
                (1, forecast, "the overlap will have fallen to its target"),
                (2, on_the_way, "before that, because the error of the forecast is large"),
                (3, safe, "nothing is known of the motion"), (4, telecommand, "the ground asked for this time"))

ILP_ENUMERATION(CaptureState, (0, pending, ""), (1, exposed, ""), (2, no_frame, "no frame came"), (3, rejected, ""),
                (4, superseded, ""))

ILP_ENUMERATION(OverlapDecision, (0, skipped, ""), (1, selected, "it is a keyframe"),
                (2, new_strip, "it is the first keyframe of a new strip"), (3, rejected, ""))

ILP_ENUMERATION(StripEnd, (0, open, "still open"), (1, overlap_lost, "overlap lost"),
                (2, overlap_unknown, "overlap unknown"), (3, pose_lost, "pose lost"),
                (4, end_of_flight, "end of flight"), (5, commanded, "ended by command"))

ILP_ENUMERATION(ScaleSource, (0, first_baseline, "the first baseline is 1"), (1, altimeter, "metres by the altimeter"))

/// Levels of reduced work (fsw/shared/work_level.hpp).
ILP_ENUMERATION(ReducedWork, (0, full, ""), (1, fewer_features, "fewer features"),
                (2, coarser_stereo, "fewer features and coarser stereo"))

ILP_ENUMERATION(PoseState, (0, provisional, "it may"), (1, final, "it never changes"), (2, failed, "there is no pose"))

ILP_ENUMERATION(DepthVerdict, (0, ok, ""), (1, no_partner, "no stereo partner"),
                (2, rectification_impossible, "not rectifiable"), (3, too_few_valid, "too few valid depths"))

/// In the order in which they are made: when the image of a keyframe exists, so does its depth map if there is one.
ILP_ENUMERATION(ProductKind, (0, depth, ""), (1, image, ""))

ILP_ENUMERATION(ProductScheme, (0, lossy_region, "lossy, region first"), (1, lossless_region, "lossless region"),
                (2, thumbnail, ""))

ILP_ENUMERATION(ProductState, (0, stored, "not all of it has been handed to the link"),
                (1, sent, "all of it has been handed to the link"), (2, acknowledged, "the ground holds all of it"),
                (3, dropped, "given up"))

ILP_ENUMERATION(DownlinkKind, (0, product, ""), (1, records, ""), (2, points, "sparse points"))

ILP_ENUMERATION(CommandKind, (0, end_strip, "end of the strip"),
                (1, capture, "an image at a time that must not be past"),
                (2, refine, "the products of a keyframe go before others"),
                (3, capture_soon, "an image at a time, or at once where that is past"),
                (4, delete_product, "the ground gives up a product"),
                (5, restart, "a component goes back to its checkpoint"),
                (6, report_enable, "a periodic housekeeping report"),
                (7, report_disable, "a periodic housekeeping report"), (8, report_once, "a housekeeping report now"),
                (9, report_interval, "the interval of a housekeeping report"),
                (10, event_enable, "an event is reported"), (11, event_disable, "an event is not reported"),
                (12, events_report, "the events that are not reported"))

ILP_ENUMERATION(TransferState, (0, waiting, "none of it has gone"), (1, sending, "some of it has gone"),
                (2, sent, "all of it has gone once; gaps are filled until the ground says that it has the file"),
                (3, delivered, "the ground holds it, whole and checked"))

/// The ground's request for a transfer.
ILP_ENUMERATION(TransferWish, (0, none, ""), (1, suspend, ""), (2, resume, ""), (3, cancel, ""))

ILP_ENUMERATION(UplinkState, (0, checked, "it can be activated"), (1, rejected, ""), (2, active, ""),
                (3, superseded, "it was active, another one has taken its place"))

/// The reason for the start of the software.
ILP_ENUMERATION(StartReason, (0, first, "the store is new"), (1, stopped, "the life before was ended in order"),
                (2, process_died, "killed or crashed, on a board that went on"),
                (3, board_reset, "power was lost, or the board was reset"),
                (4, watchdog, "the board's watchdog had bitten"))

/// The parameters with which a life begins (docs/getting-back-in.md).
ILP_ENUMERATION(ConfigurationStage, (0, as_set, "what was set"), (1, last_good, "the last good configuration"),
                (2, built_in, "built-in defaults"))

}  // namespace ilp

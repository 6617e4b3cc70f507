// The list of the flight's components. A new component is added to this list and gets a row in the schedule
// (cfg/schedule.hpp).
#pragma once

#include "bsp/flight/component_list.hpp"
#include "fsw/commanding/telecommand_guard.hpp"
#include "fsw/commanding/telecommander.hpp"
#include "fsw/downlink/downlink.hpp"
#include "fsw/downlink/file_delivery.hpp"
#include "fsw/imaging/acquisition.hpp"
#include "fsw/imaging/capture_clock.hpp"
#include "fsw/imaging/overlap_checker.hpp"
#include "fsw/localisation/map_fix.hpp"
#include "fsw/motion/camera_calibrator.hpp"
#include "fsw/motion/structure_and_motion.hpp"
#include "fsw/navigation/navigator.hpp"
#include "fsw/places/place_memory.hpp"
#include "fsw/products/compressor.hpp"
#include "fsw/products/richness_scorer.hpp"
#include "fsw/storage/scrubber.hpp"
#include "fsw/storage/storage_manager.hpp"
#include "fsw/telemetry/telemetry.hpp"
#include "fsw/terrain/dense_matcher.hpp"

namespace ilp {

using FlightComponents =
    ComponentList<Telecommander, CaptureClock, Acquisition, OverlapChecker, Navigator, CameraCalibrator,
                  StructureAndMotion, DenseMatcher, MapFix, PlaceMemory, RichnessScorer, Compressor, StorageManager,
                  Downlink, FileDelivery, TelecommandGuard, Scrubber, TelemetryReporter>;

}  // namespace ilp

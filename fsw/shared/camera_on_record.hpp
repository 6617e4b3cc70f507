// The camera record and its copy.
#pragma once

#include "hal/store/store_view.hpp"

namespace ilp {

/// Reads the present camera or the nominal one (`camera_id`, `nominal_camera_id`). Nothing can be computed without the
/// present one, so it is stored twice: if it is damaged, its copy is read.
Status get_camera(Reader<CameraRecord> store, std::int64_t id, CameraRecord& camera);
/// The camera with which the flight began, as it was given or as its nominal one: `not_found` before a flight.
Status get_first_camera(Reader<CameraRecord> store, CameraRecord& camera);
/// Makes `camera` the present one. Call it within a transaction.
Status put_camera(StorePart<Writes<CameraRecord>> store, const CameraRecord& camera);

}  // namespace ilp

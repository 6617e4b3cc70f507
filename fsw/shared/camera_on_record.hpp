// Reads and writes the camera records, with the copy of the present camera.
#pragma once

#include "hal/store/store_view.hpp"

namespace ilp {

/// Reads the present camera (`id` is camera_id) or the nominal one (nominal_camera_id). The present camera is stored
/// twice, because nothing can be computed without it: if its record is damaged, the copy is read.
Status get_camera(Reader<CameraRecord> store, std::int64_t id, CameraRecord& camera);
/// Reads the camera with which the flight began: the nominal one if there is one, otherwise the present one. Returns
/// `not_found` if the store has no camera yet.
Status get_first_camera(Reader<CameraRecord> store, CameraRecord& camera);
/// Writes `camera` as the present camera, with its copy. Call it within a transaction.
Status put_camera(StorePart<Writes<CameraRecord>> store, const CameraRecord& camera);

}  // namespace ilp

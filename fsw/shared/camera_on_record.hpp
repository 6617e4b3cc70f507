// The camera and its copy.
#pragma once

#include "hal/store/store_view.hpp"

namespace ilp {

/// The camera as it is at present, or the nominal one (`camera_id`, `nominal_camera_id`). Nothing is made without the
/// present one, so that it is on record twice: where it is damaged, its copy is read.
Status get_camera(Reader<CameraRecord> store, std::int64_t id, CameraRecord& camera);
/// Within a transaction: `camera` is the present one from now on.
Status put_camera(StorePart<Writes<CameraRecord>> store, const CameraRecord& camera);

}  // namespace ilp

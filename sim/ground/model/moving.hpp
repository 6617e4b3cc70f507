// From a finished model to the flight: in whose world the model stands, and how poses, points and depths move into it.
#pragma once

#include <cstdint>
#include <optional>

#include "fsw/vision/geometry/similarity.hpp"
#include "sim/ground/model/model.hpp"

namespace ilp::model {

/// The strip in whose world the model shall stand: the first one in metres, or else the first one with two poses.
[[nodiscard]] std::int64_t reference_strip(const intake::Flight& flight, const Scene& scene, const Model& model);

/// The similarity that brings a strip nearest to where the model has its cameras; none for fewer than two of them.
[[nodiscard]] std::optional<Similarity> model_from_strip(const Scene& scene, const Model& model, std::int64_t strip_id);

/// Each keyframe takes its pose of the model, its points and depths move with it, and it belongs to `strip_id` from now
/// on. `in_metres`: the model's unit is a metre, otherwise that of the strip. Its errors are those of the model where
/// they are known, and otherwise the flight's in the model's unit. A keyframe without a pose of the flight gets one.
void move_flight(const Scene& scene, const Model& model, std::int64_t strip_id, bool in_metres, intake::Flight& flight);

}  // namespace ilp::model

// Moves the poses, points and depths of a flight into a finished model.
#pragma once

#include <cstdint>
#include <optional>

#include "fsw/vision/geometry/similarity.hpp"
#include "sim/ground/model/model.hpp"

namespace ilp::model {

/// The strip whose world the model gets: among strips with two or more posed views in the model the first one in
/// metres, or else the first one. 0: there is no such strip.
[[nodiscard]] std::int64_t reference_strip(const intake::Flight& flight, const Scene& scene, const Model& model);

/// The similarity that best aligns the strip's cameras, by the flight's poses, with those of the model. None for fewer
/// than two cameras.
[[nodiscard]] std::optional<Similarity> model_from_strip(const Scene& scene, const Model& model, std::int64_t strip_id);

/// Gives each keyframe of the model its pose in the model, moves its points and depths, and sets its strip to
/// `strip_id`. A keyframe that the flight has not posed gets a pose too. The covariance is the model's if it is known,
/// else the flight's in the model's unit. `in_metres`: the model's unit is the metre; otherwise it is that of the
/// strip.
void move_flight(const Scene& scene, const Model& model, std::int64_t strip_id, bool in_metres, intake::Flight& flight);

}  // namespace ilp::model

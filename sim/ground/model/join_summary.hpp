// What the report says of a model.
#pragma once

#include "sim/ground/model/joined_model.hpp"
#include "sim/ground/model/model.hpp"

namespace ilp::model {

[[nodiscard]] JoinedModel summary_of(const intake::Flight& flight, const Scene& scene, const Model& model,
                                     std::int64_t strip_id);

/// `flight` as it came down. Strips with keyframes in none of the models, with the reason.
[[nodiscard]] std::vector<StripApart> strips_apart(const intake::Flight& flight,
                                                   const std::vector<JoinedModel>& models);

}  // namespace ilp::model

// Summarises joined models for the report.
#pragma once

#include "sim/ground/model/joined_model.hpp"
#include "sim/ground/model/model.hpp"

namespace ilp::model {

/// The summary of one model. `strip_id`: names the model and its world. `flight`: before it is moved into the model.
[[nodiscard]] JoinedModel summary_of(const intake::Flight& flight, const Scene& scene, const Model& model,
                                     std::int64_t strip_id);

/// The strips that have keyframes outside all models, with the reason. `flight`: before it is moved into the models.
[[nodiscard]] std::vector<StripApart> strips_apart(const intake::Flight& flight,
                                                   const std::vector<JoinedModel>& models);

}  // namespace ilp::model

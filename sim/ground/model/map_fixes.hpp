// Fixes on the map of an orbiter in a model: where it stands on the map, and what the fixes say of its views.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "sim/ground/intake/flight_model.hpp"
#include "sim/ground/model/model.hpp"

namespace ilp::model {

/// Fewer fixes than these place no model: a wrong one would not be known among two.
inline constexpr std::size_t least_fixes = 3;

/// The map that most accepted fixes of the flight are on. Its plane has x to the east, y to the north, and z is the
/// elevation (local_plane.hpp). None where the flight has fewer than least_fixes on it.
[[nodiscard]] std::optional<intake::MapPlace> map_of(const intake::Flight& flight);

/// Moves the model as a whole to where its fixes on the map put it, and takes these fixes as priors of its views. False
/// if fewer than least_fixes are on the map, or if they do not say what is up, where north is, and how long a unit: the
/// model is as it was.
[[nodiscard]] bool place_on_map(const Scene& scene, const intake::MapPlace& map, Model& model);

/// Models on one map in one.
[[nodiscard]] Model united(const Scene& scene, std::vector<Model> parts);

/// By fix of the model, the norm of its six residuals in units of its estimated errors, times FixWeights::error_factor.
[[nodiscard]] std::vector<double> fix_errors(const Scene& scene, const Model& model);

/// Weighs the fixes against the sightings of the model where it is placed now. Losses are as wide as most fixes are
/// off. `adjusted`: the model has been adjusted to its fixes. What most of them are off by beyond their estimated
/// errors is then theirs as far as neighbouring fixes differ, and otherwise the images': a lens that is not known well
/// bends a model by more than its sightings state. False where nothing of that is left to change.
bool weigh_fixes(const Scene& scene, bool adjusted, Model& model);

/// Least scale of Cauchy's loss of fixes, and from which error on a fix contradicts, in the units of fix_errors(). One
/// of 360 000 right ones does.
inline constexpr double last_fix_loss = 5, contradicting_fix = 6;

}  // namespace ilp::model

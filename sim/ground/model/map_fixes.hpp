// Places a model on an orbiter's map by the fixes of its keyframes, and weighs the fixes against the images.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "sim/ground/intake/flight_model.hpp"
#include "sim/ground/model/model.hpp"

namespace ilp::model {

/// Fewest fixes that place a model: among two a wrong one could not be recognised.
inline constexpr std::size_t least_fixes = 3;

/// The map with most accepted fixes of the flight; none if it has fewer than least_fixes. Its plane has x to the east
/// and y to the north, and z is the elevation (local_plane.hpp).
[[nodiscard]] std::optional<intake::MapPlace> map_of(const intake::Flight& flight);

/// Moves the model by the similarity that its fixes on the map determine, and makes these fixes priors of its views.
/// Returns false, and does not change the model, if fewer than least_fixes are on the map, or if they do not determine
/// the vertical, north and the scale.
[[nodiscard]] bool place_on_map(const Scene& scene, const intake::MapPlace& map, Model& model);

/// Unites models that are on one map. `parts` must not be empty.
[[nodiscard]] Model united(const Scene& scene, std::vector<Model> parts);

/// For each fix of the model, the norm of its six residuals, normalised by its estimated errors times
/// FixWeights::error_factor.
[[nodiscard]] std::vector<double> fix_errors(const Scene& scene, const Model& model);

/// Sets the weights of the fixes against the sightings from the model's current residuals. The scale of the loss
/// follows the median residual. `adjusted`: the model has been adjusted to its fixes, so that the factors of FixWeights
/// are estimated too. Fix residuals above the estimated errors raise error_factor as far as neighbouring fixes differ
/// from each other; the rest raises image_factor, because a poorly known lens bends a model by more than the errors of
/// its sightings explain. Returns whether a factor has changed noticeably.
bool weigh_fixes(const Scene& scene, bool adjusted, Model& model);

/// Smallest scale of Cauchy's loss of fixes, and error from which on a fix is an outlier; both as in fix_errors(). One
/// of 360 000 right fixes exceeds the latter.
inline constexpr double last_fix_loss = 5, contradicting_fix = 6;

}  // namespace ilp::model

// Chooses the patches of a sheet, counts their votes for a shift, and decides whether the votes are sufficient.
#pragma once

#include <span>

#include "fsw/base/verdicts.hpp"
#include "fsw/vision/map/keyframe_sheet.hpp"
#include "fsw/vision/map/map_workspace.hpp"

namespace ilp {

/// Chooses patches without overlap on the grid that has most patches with at least nine tenths known cells. If there
/// are more than max_map_patches, it takes evenly spread ones. Writes workspace.patches and uses workspace.sums as
/// scratch. Returns the number of patches.
std::int32_t choose_patches(const MapChannels<max_map_sheet_side>& sheet, std::int32_t side,
                            MapRegistrationWorkspace& workspace);

/// Sums of the patches' correlation surfaces, one for each quarter (MapPatch::quarter).
class VoteSurfaces {
 public:
  VoteSurfaces(MapRegistrationWorkspace& workspace, std::int32_t lags) : workspace_(workspace), lags_(lags) {}

  void clear();
  /// Adds workspace.surface, which search_patch() wrote for this patch, to the sum of its quarter, and sets the patch's
  /// best lag. Returns the number of lags at which the map is known. Returns 0 and adds nothing if these are less than
  /// half of all lags, or if no score is positive.
  std::int32_t add(MapPatch& patch);
  /// Sum of the surfaces of the quarters whose bits are set in `which`, at a lag.
  [[nodiscard]] std::int64_t at(std::uint32_t which, std::int32_t column, std::int32_t row) const;
  struct Peak {
    std::int32_t column = 0, row = 0;      ///< lag
    double fine_column = 0, fine_row = 0;  ///< lag with its fraction
  };
  /// The highest peak; the first of equal ones.
  [[nodiscard]] Peak peak(std::uint32_t which) const;
  static constexpr std::uint32_t all = 15;

 private:
  MapRegistrationWorkspace& workspace_;
  std::int32_t lags_;
};

struct MapVote {
  MapVerdict verdict = MapVerdict::no_texture;
  std::int32_t column = 0, row = 0;      ///< lag of the peak
  double fine_column = 0, fine_row = 0;  ///< lag of the peak with its fraction
  double evidence = 0;                   ///< vote_evidence()
  /// Patches used, patches that agree with the peak, most patches that agree on another shift, and quarters whose own
  /// peak agrees.
  std::int32_t patches = 0, votes = 0, rivals = 0, quarters = 0;
};
/// -ln(P lags / 9). P is the binomial probability that by chance at least `votes` of `patches` are within a pixel of a
/// given shift, each with probability 9 / lags. lags / 9 is the number of separate shifts. May be negative.
[[nodiscard]] double vote_evidence(std::int32_t votes, std::int32_t patches, double lags);
/// Counts the votes of the patches that are used, and gives the verdict. `side`: lags along each axis. `lags`: mean
/// number of known lags of a patch.
[[nodiscard]] MapVote count_votes(std::span<const MapPatch> patches, const VoteSurfaces& surfaces, std::int32_t side,
                                  double lags, double min_evidence);

/// Offset of the maximum of a parabola through three values from the middle one, clamped to -1/2 to 1/2.
[[nodiscard]] double vertex(double before, double middle, double after);

}  // namespace ilp

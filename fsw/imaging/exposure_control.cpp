#include "fsw/imaging/exposure_control.hpp"

#include <algorithm>
#include <array>

#include "fsw/base/status_values.hpp"

namespace ilp {
namespace {

constexpr std::int32_t row_step = 4;
constexpr std::int32_t white = 250;
constexpr std::int32_t black = 2;
/// Largest change at a time, and the one for an image that is white in some places only.
constexpr std::int64_t largest_factor = 4;
constexpr std::int64_t middle_factor = 2;
constexpr std::int32_t mostly_white_permille = 250;
constexpr std::int32_t most_damping = 3;
/// Images without an effect that are waited for, and changes in a row without one that end the control.
constexpr std::int32_t patience_images = 4;
constexpr std::int32_t most_without_effect = 3;
/// A change of a setting that is smaller than this share of it is none.
constexpr std::int64_t least_change_share = 16;

/// Whether a and b differ by less than a seventh of the larger one.
bool within_an_eighth(std::int64_t a, std::int64_t b) {
  return 8 * a >= 7 * b && 8 * b >= 7 * a;
}

bool same(std::int64_t a, std::int64_t b) {
  return (a > b ? a - b : b - a) * least_change_share <= b;
}

std::int64_t product_of(const ExposureSetting& setting) {
  return setting.exposure_us * setting.gain_milli;
}

}  // namespace

ImageBrightness measure_brightness(GrayView image) {
  std::array<std::int32_t, 256> counts{};
  std::int32_t pixels = 0;
  for (std::int32_t y = 0; y < image.height; y += row_step) {
    const std::uint8_t* const row = image.row(y);
    for (std::int32_t x = 0; x < image.width; ++x) ++counts[row[x]];
    pixels += image.width;
  }
  ImageBrightness result;
  std::int32_t above = 0;
  for (std::int32_t grey = 255; grey >= 0; --grey) {
    above += counts[static_cast<std::size_t>(grey)];
    if (grey == white && pixels > 0) {
      result.white_permille = static_cast<std::int32_t>(std::int64_t{1000} * above / pixels);
    }
    if (result.bright == 0 && 100 * std::int64_t{above} >= pixels) result.bright = grey;
  }
  return result;
}

std::int64_t longest_exposure_us(double blur_px, double speed_px_s, std::int64_t longest_us) {
  if (!(speed_px_s > 0)) return longest_us;
  const double bound_us = 1e6 * blur_px / speed_px_s;
  return bound_us < static_cast<double>(longest_us) ? static_cast<std::int64_t>(bound_us) : longest_us;
}

void ExposureControl::begin(const ExposureRange& range) {
  reset();
  range_ = range;
  begun_ = true;
}

void ExposureControl::asked(const ExposureSetting& setting) {
  from_quiet_ = !asked_.known() || waited_ > patience_images;
  asked_ = setting;
  waited_ = 0;
  // Nothing can be told from an image that stays white or black, or from a small change.
  const std::int64_t now = product_of(setting), then = product_of(before_);
  const bool clear = 4 * now >= 5 * then || 4 * then >= 5 * now;
  judged_ = !clear || bright_before_ >= white || bright_before_ <= black;
}

bool ExposureControl::shows_effect(const ImageBrightness& image) const {
  const bool brighter = product_of(asked_) > product_of(before_);
  const std::int32_t moved = brighter ? image.bright - bright_before_ : bright_before_ - image.bright;
  return moved > std::max(2, bright_before_ / 16);
}

bool ExposureControl::must_wait(const ImageBrightness& image, const ExposureSetting& taken_with, Status& event) {
  if (!asked_.known()) return false;
  ++waited_;
  const bool earlier = taken_with != asked_;
  if (!earlier && judged_) return waited_ <= delay_;
  if (!earlier && shows_effect(image)) {
    // Effects of several changes at once say less about the delay.
    delay_ = from_quiet_ ? waited_ - 1 : std::max(delay_, waited_ - 1);
    without_effect_ = 0;
    judged_ = true;
    return false;
  }
  if (waited_ <= patience_images) return true;
  judged_ = true;
  if (++without_effect_ < most_without_effect) return false;
  abandoned_ = true;
  event = {StatusCode::exposure_not_obeyed, without_effect_, asked_.exposure_us};
  return true;
}

ExposureControl::Ratio ExposureControl::correction(const ImageBrightness& image, const ExposureGoal& goal) {
  if (image.white_permille >= mostly_white_permille) return {1, largest_factor};
  if (image.bright >= white) return {1, middle_factor};
  if (image.bright <= black) return {largest_factor, 1};
  if (within_an_eighth(image.bright, goal.bright_grey)) return {};
  if (goal.bright_grey > largest_factor * image.bright) return {largest_factor, 1};
  if (image.bright > largest_factor * goal.bright_grey) return {1, largest_factor};
  return {goal.bright_grey, image.bright};
}

std::int64_t ExposureControl::damped(std::int64_t product, const Ratio& wanted) {
  if (wanted.over == wanted.under) return product;
  const std::int32_t direction = wanted.over > wanted.under ? 1 : -1;
  // Long after the latest change it is the light that has changed.
  const bool quiet = waited_ > patience_images;
  const bool turned = !quiet && direction == -direction_;
  if (quiet) damping_ = 0;
  const bool coarse = bright_before_ >= white || bright_before_ <= black;
  if (!turned) {
    damping_ = std::max(damping_ - 1, 0);
  } else if (!coarse) {
    damping_ = std::min(damping_ + 1, most_damping);
  }
  // It may have gone too far because the camera obeys later than is known.
  if (turned) delay_ = std::min(delay_ + 1, patience_images);
  direction_ = direction;
  const std::int64_t full = product * wanted.over / wanted.under;
  return product + (full - product) / (std::int64_t{1} << damping_);
}

ExposureSetting ExposureControl::share_out(std::int64_t product, const ExposureGoal& goal) const {
  const std::int64_t step = std::max<std::int64_t>(range_.step_us, 1);
  const std::int64_t most_us = std::max(std::min(range_.most_us, goal.longest_us), range_.least_us);
  const std::int64_t most_gain =
      std::max(std::min(range_.most_gain_milli, goal.most_gain_milli), range_.least_gain_milli);
  ExposureSetting next;
  next.exposure_us = std::clamp(product / range_.least_gain_milli, range_.least_us, most_us);
  next.exposure_us = range_.least_us + (next.exposure_us - range_.least_us) / step * step;
  next.gain_milli = std::clamp(product / next.exposure_us, range_.least_gain_milli, most_gain);
  return next;
}

void ExposureControl::judge_limits(std::int64_t wanted, const ExposureSetting& next, Status& event) {
  const std::int64_t given = product_of(next);
  std::int32_t limit = 0;
  if (8 * given < 7 * wanted) limit = static_cast<std::int32_t>(Brightness::too_dark);
  if (8 * wanted < 7 * given) limit = static_cast<std::int32_t>(Brightness::too_bright);
  if (limit != 0 && limit != limit_) event = {StatusCode::exposure_limited, limit, next.exposure_us};
  limit_ = limit;
}

ExposureControl::Answer ExposureControl::evaluate(const ImageBrightness& image, const ExposureSetting& taken_with,
                                                  const ExposureGoal& goal, ExposureSetting& next, Status& event) {
  event = {};
  if (abandoned_ || !taken_with.known() || must_wait(image, taken_with, event)) return Answer::keep;
  const std::int64_t wanted = damped(product_of(taken_with), correction(image, goal));
  next = share_out(wanted, goal);
  judge_limits(wanted, next, event);
  if (same(next.exposure_us, taken_with.exposure_us) && same(next.gain_milli, taken_with.gain_milli)) {
    return Answer::keep;
  }
  before_ = taken_with;
  bright_before_ = image.bright;
  return Answer::change;
}

}  // namespace ilp

#include "fsw/vision/twoview/robust/gric.hpp"

#include "fsw/base/math.hpp"

namespace ilp {
namespace {

constexpr double data_dimension = 4;  // r
constexpr double lambda_3 = 2;

}  // namespace

void Gric::add(double squared_px) {
  const double limit = lambda_3 * (data_dimension - model_.dimension);
  const double residual = squared_px / variance_;
  residuals_ += residual < limit ? residual : limit;
  count_ += 1;
}

double Gric::value() const {
  if (count_ == 0) return 0;
  const double lambda_1 = det_log(data_dimension);
  const double lambda_2 = det_log(data_dimension * count_);
  return residuals_ + lambda_1 * model_.dimension * count_ + lambda_2 * model_.parameters;
}

}  // namespace ilp

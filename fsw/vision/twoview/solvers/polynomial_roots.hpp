// Finds the real roots of a polynomial: isolates them by Sturm's sequence and refines them inside their brackets.
// Bounded and deterministic.
#pragma once

#include <cmath>

namespace ilp {

/// Coefficients in ascending order: c[0] + c[1] x + ... + c[Degree] x^Degree.
template <int Degree>
class RealRoots {
 public:
  /// Writes the distinct real roots of magnitude below 2^30, from left to right, to `roots` and returns their number. A
  /// polynomial that is zero or not finite has none.
  int find(const double (&coefficients)[Degree + 1], double (&roots)[Degree]) {
    if (!build_chain(coefficients)) return 0;
    const double bound = root_bound();
    int count = 0;
    int open = 0;
    push(open, {-bound, bound, sign_changes(-bound), sign_changes(bound)});
    // Every step halves an interval that holds a root; after 60 halvings no interval can be halved.
    for (int step = 0; step < max_steps && open > 0; ++step) {
      const Interval now = stack_[--open];
      const int inside = now.changes_low - now.changes_high;
      if (inside <= 0 || count == Degree) continue;
      const double middle = 0.5 * (now.low + now.high);
      if (inside == 1 && refine(now.low, now.high, roots[count])) {
        ++count;
        continue;
      }
      if (now.high - now.low < 1e-13 * bound) {
        roots[count++] = middle;  // a multiple root, or several that double precision cannot separate
        continue;
      }
      const int changes = sign_changes(middle);
      push(open, {middle, now.high, changes, now.changes_high});
      push(open, {now.low, middle, now.changes_low, changes});
    }
    return count;
  }

 private:
  struct Interval {
    double low, high;
    int changes_low, changes_high;
  };
  enum : int { max_steps = 60 * Degree, stack_size = Degree + 64 };

  void push(int& open, const Interval& interval) {
    if (open < stack_size) stack_[open++] = interval;
  }

  /// chain_[0] is the polynomial, chain_[1] its derivative, chain_[i + 1] the negated remainder of the two before.
  bool build_chain(const double (&coefficients)[Degree + 1]) {
    double largest = 0;
    for (const double c : coefficients) largest = std::fmax(largest, std::fabs(c));
    if (!(largest > 0) || !std::isfinite(largest)) return false;
    degree_[0] = Degree;
    for (int i = 0; i <= Degree; ++i) chain_[0][i] = coefficients[i] / largest;
    if (!trim(0)) return false;
    if (degree_[0] == 0) return false;
    degree_[1] = degree_[0] - 1;
    for (int i = 1; i <= degree_[0]; ++i) chain_[1][i - 1] = i * chain_[0][i];
    length_ = 2;
    while (length_ <= Degree && degree_[length_ - 1] > 0 && append_remainder()) ++length_;
    return true;
  }

  /// Removes leading coefficients that are only rounding errors, because a division by them would be meaningless.
  bool trim(int i) {
    while (degree_[i] > 0 && std::fabs(chain_[i][degree_[i]]) < 1e-14) --degree_[i];
    return degree_[i] > 0 || std::fabs(chain_[i][0]) >= 1e-14;
  }

  bool append_remainder() {
    const double* divisor = chain_[length_ - 1];
    const int divisor_degree = degree_[length_ - 1];
    double remainder[Degree + 1];
    for (int i = 0; i <= Degree; ++i) remainder[i] = i <= degree_[length_ - 2] ? chain_[length_ - 2][i] : 0.0;
    for (int top = degree_[length_ - 2]; top >= divisor_degree; --top) {
      const double quotient = remainder[top] / divisor[divisor_degree];
      for (int i = 0; i < divisor_degree; ++i) remainder[top - divisor_degree + i] -= quotient * divisor[i];
    }
    double largest = 0;
    for (int i = 0; i < divisor_degree; ++i) largest = std::fmax(largest, std::fabs(remainder[i]));
    if (!(largest > 1e-15) || !std::isfinite(largest)) return false;
    for (int i = 0; i < divisor_degree; ++i) chain_[length_][i] = -remainder[i] / largest;
    degree_[length_] = divisor_degree - 1;
    return trim(length_);
  }

  double value(int i, double x) const {
    double result = chain_[i][degree_[i]];
    for (int k = degree_[i] - 1; k >= 0; --k) result = result * x + chain_[i][k];
    return result;
  }

  int sign_changes(double x) const {
    int changes = 0;
    bool previous = std::signbit(value(0, x));
    for (int i = 1; i < length_; ++i) {
      const double v = value(i, x);
      if (v == 0) continue;
      const bool negative = std::signbit(v);
      if (negative != previous) ++changes;
      previous = negative;
    }
    return changes;
  }

  /// A power of two b with |c_n| b^n > sum of |c_k| b^k, k < n: no root has a larger magnitude.
  double root_bound() const {
    double bound = 1;
    for (int step = 0; step < 30; ++step) {
      double rest = 0;
      const int n = degree_[0];
      for (int k = 0; k < n; ++k) rest = rest / bound + std::fabs(chain_[0][k]);
      if (std::fabs(chain_[0][n]) * bound > rest) return bound;
      bound *= 2;
    }
    return bound;
  }

  /// Newton's method, with bisection when it would leave the bracket. Returns false if both ends have the same sign.
  bool refine(double low, double high, double& root) const {
    double value_low = value(0, low);
    const double value_high = value(0, high);
    if (std::signbit(value_low) == std::signbit(value_high) && value_low != 0 && value_high != 0) return false;
    double x = 0.5 * (low + high);
    for (int step = 0; step < 80; ++step) {
      double f = chain_[0][degree_[0]];
      double slope = 0;
      for (int k = degree_[0] - 1; k >= 0; --k) {
        slope = slope * x + f;
        f = f * x + chain_[0][k];
      }
      if (f == 0) break;
      if (std::signbit(f) == std::signbit(value_low)) {
        low = x;
        value_low = f;
      } else {
        high = x;
      }
      double next = x - f / slope;
      if (!(next > low && next < high)) next = 0.5 * (low + high);
      const double move = std::fabs(next - x);
      x = next;
      if (move <= 1e-14 * std::fabs(x)) break;
    }
    root = x;
    return true;
  }

  double chain_[Degree + 1][Degree + 1];
  int degree_[Degree + 1];
  int length_ = 0;
  Interval stack_[stack_size];
};

}  // namespace ilp

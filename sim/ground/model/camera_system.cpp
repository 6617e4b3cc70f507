#include "sim/ground/model/camera_system.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <set>
#include <utility>

#include "fsw/base/vector_width.hpp"

namespace ilp::model {
namespace {

using Numbers = std::vector<std::uint32_t>;

/// By camera, ascending, both directions, without itself.
std::vector<Numbers> graph_of(const RelatedCameras& related) {
  std::vector<Numbers> graph(related.size());
  for (std::uint32_t a = 0; a < related.size(); ++a) {
    for (const std::uint32_t b : related[a]) {
      if (a == b) continue;
      graph[a].push_back(b);
      graph[b].push_back(a);
    }
  }
  for (Numbers& of_camera : graph) {
    std::sort(of_camera.begin(), of_camera.end());
    of_camera.erase(std::unique(of_camera.begin(), of_camera.end()), of_camera.end());
  }
  return graph;
}

/// Eliminates cameras one after the other; all those that one is related to are then related to each other. Next is the
/// one that adds fewest relations.
class Elimination {
 public:
  explicit Elimination(std::vector<Numbers>& graph) : graph_(graph), added_(graph.size()), changed_(graph.size(), 0) {
    for (std::uint32_t c = 0; c < graph.size(); ++c) {
      std::size_t related = 0;
      for (const std::uint32_t other : graph[c]) related += in_common(c, other);
      added_[c] = (graph[c].size() * (graph[c].size() - (graph[c].empty() ? 0 : 1)) - related) / 2;
      next_.emplace(added_[c], c);
    }
  }

  /// The cameras in their order. `graph` holds then, by camera, those after it that it fills.
  Numbers order() {
    Numbers eliminated;
    while (!next_.empty()) {
      eliminated.push_back(next_.begin()->second);
      next_.erase(next_.begin());
      eliminate(eliminated.back());
    }
    return eliminated;
  }

 private:
  [[nodiscard]] std::size_t in_common(std::uint32_t a, std::uint32_t b) {
    common_.clear();
    std::set_intersection(graph_[a].begin(), graph_[a].end(), graph_[b].begin(), graph_[b].end(),
                          std::back_inserter(common_));
    return common_.size();
  }

  void change(std::uint32_t camera) {
    if (changed_[camera] != 0) return;
    changed_[camera] = 1;
    next_.erase({added_[camera], camera});
    list_.push_back(camera);
  }

  void relate(std::uint32_t a, std::uint32_t b) {
    const std::size_t common = in_common(a, b);
    for (const std::uint32_t c : common_) {
      change(c);
      --added_[c];
    }
    added_[a] += graph_[a].size() - common;
    added_[b] += graph_[b].size() - common;
    graph_[a].insert(std::lower_bound(graph_[a].begin(), graph_[a].end(), b), b);
    graph_[b].insert(std::lower_bound(graph_[b].begin(), graph_[b].end(), a), a);
  }

  void eliminate(std::uint32_t camera) {
    list_.clear();
    for (const std::uint32_t other : graph_[camera]) {
      change(other);
      added_[other] -= graph_[other].size() - 1 - in_common(other, camera);
    }
    for (const std::uint32_t other : graph_[camera])
      graph_[other].erase(std::lower_bound(graph_[other].begin(), graph_[other].end(), camera));
    for (const std::uint32_t other : graph_[camera]) {
      Numbers unrelated;
      std::set_difference(graph_[camera].begin(), graph_[camera].end(), graph_[other].begin(), graph_[other].end(),
                          std::back_inserter(unrelated));
      for (const std::uint32_t one : unrelated) {
        if (one > other) relate(other, one);
      }
    }
    for (const std::uint32_t c : list_) {
      changed_[c] = 0;
      next_.emplace(added_[c], c);
    }
  }

  std::vector<Numbers>& graph_;
  std::vector<std::size_t> added_;  ///< by camera, relations that its elimination adds
  std::set<std::pair<std::size_t, std::uint32_t>> next_;
  Numbers common_, list_;  ///< the latter: of those whose numbers change
  std::vector<std::uint8_t> changed_;
};

/// Of orders that fill the same, the one in which columns that need each other stand beside each other: each camera
/// comes right after all those that lead to it (Davis, 4.3).
Numbers in_postorder(const Numbers& eliminated, const std::vector<Numbers>& filled) {
  const auto count = static_cast<std::uint32_t>(eliminated.size());
  Numbers number(count), parent(count, count), size(count, 1), end(count + 1, count), ordered(count);
  for (std::uint32_t i = 0; i < count; ++i) number[eliminated[i]] = i;
  for (std::uint32_t i = 0; i < count; ++i) {
    for (const std::uint32_t other : filled[eliminated[i]]) parent[i] = std::min(parent[i], number[other]);
    if (parent[i] < count) size[parent[i]] += size[i];
  }
  for (std::uint32_t i = count; i-- > 0;) {
    end[i] = end[parent[i]];
    end[parent[i]] -= size[i];
    ordered[--end[i]] = eliminated[i];
  }
  return ordered;
}

/// c -= a b, in an order that compilers turn into vectors.
void subtract_product(const Mat6& a, const Mat6& b, Mat6& c) {
  for (int column = 0; column < 6; ++column) {
    Vec6 sum = c.col(column);
    for (int k = 0; k < 6; ++k) {
      const double factor = b(k, column);
      for (int row = 0; row < 6; ++row) sum[row] -= a(row, k) * factor;
    }
    c.col(column) = sum;
  }
}

}  // namespace

CameraSystem::CameraSystem(const RelatedCameras& related) : order_(related.size()), left_(related.size()) {
  std::vector<Numbers> graph = graph_of(related);
  const Numbers eliminated = Elimination(graph).order(), cameras = in_postorder(eliminated, graph);
  for (std::uint32_t i = 0; i < cameras.size(); ++i) order_[cameras[i]] = i;
  for (std::uint32_t column = 0; column < cameras.size(); ++column) {
    first_.push_back(rows_.size());
    rows_.push_back(column);
    for (const std::uint32_t other : graph[cameras[column]]) rows_.push_back(order_[other]);
    std::sort(rows_.begin() + static_cast<std::ptrdiff_t>(first_.back()), rows_.end());
    for (std::size_t at = first_.back() + 1; at < rows_.size(); ++at) left_[rows_[at]].push_back({column, at});
  }
  first_.push_back(rows_.size());
  blocks_.resize(rows_.size());
  clear();
}

void CameraSystem::clear() {
  std::fill(blocks_.begin(), blocks_.end(), Mat6::Zero());
}

std::size_t CameraSystem::find(std::uint32_t row, std::uint32_t column) const {
  const auto begin = rows_.begin() + static_cast<std::ptrdiff_t>(first_[column]),
             end = rows_.begin() + static_cast<std::ptrdiff_t>(first_[column + 1]);
  return static_cast<std::size_t>(std::lower_bound(begin, end, row) - rows_.begin());
}

void CameraSystem::add(std::uint32_t a, std::uint32_t b, const Mat6& block) {
  const std::uint32_t row = order_[a], column = order_[b];
  if (row >= column) {
    blocks_[find(row, column)] += block;
  } else {
    blocks_[find(column, row)] += block.transpose();
  }
}

std::vector<CameraBlock> CameraSystem::blocks() const {
  Numbers camera(order_.size());
  for (std::uint32_t c = 0; c < order_.size(); ++c) camera[order_[c]] = c;
  std::vector<CameraBlock> blocks;
  for (std::size_t column = 0; column < order_.size(); ++column) {
    for (std::size_t at = first_[column]; at < first_[column + 1]; ++at) {
      if (!blocks_[at].isZero(0)) blocks.push_back({camera[rows_[at]], camera[column], blocks_[at]});
    }
  }
  return blocks;
}

void CameraSystem::hold(std::uint32_t camera, int unknown) {
  const std::uint32_t number = order_[camera];
  for (const Update& left : left_[number]) blocks_[left.at].row(unknown).setZero();
  for (std::size_t at = first_[number]; at < first_[number + 1]; ++at) blocks_[at].col(unknown).setZero();
  blocks_[first_[number]].row(unknown).setZero();
  blocks_[first_[number]](unknown, unknown) = 1;
}

/// `place`: by row, where this column has it; room for all rows.
void CameraSystem::update_column(std::uint32_t column, std::vector<std::size_t>& place) {
  for (std::size_t at = first_[column]; at < first_[column + 1]; ++at) place[rows_[at]] = at;
  for (const Update& left : left_[column]) {
    const Mat6 factor = blocks_[left.at].transpose();
    for (std::size_t at = left.at; at < first_[left.column + 1]; ++at)
      subtract_product(blocks_[at], factor, blocks_[place[rows_[at]]]);
  }
}

bool CameraSystem::finish_column(std::uint32_t column) {
  Mat6& diagonal = blocks_[first_[column]];
  const Eigen::LLT<Mat6> factor(diagonal);
  if (factor.info() != Eigen::Success) return false;
  diagonal = factor.matrixL();
  for (std::size_t at = first_[column] + 1; at < first_[column + 1]; ++at)
    diagonal.triangularView<Eigen::Lower>().transpose().solveInPlace<Eigen::OnTheRight>(blocks_[at]);
  return true;
}

bool CameraSystem::factor() {
  std::vector<std::size_t> place(order_.size());
  bool positive = true;
  with_widest_vectors([&] {
    for (std::uint32_t column = 0; positive && column < order_.size(); ++column) {
      update_column(column, place);
      positive = finish_column(column);
    }
  });
  return positive;
}

void CameraSystem::solve(std::vector<Vec6>& right) const {
  std::vector<Vec6> x(right.size());
  for (std::size_t camera = 0; camera < right.size(); ++camera) x[order_[camera]] = right[camera];
  for (std::size_t column = 0; column < x.size(); ++column) {
    blocks_[first_[column]].triangularView<Eigen::Lower>().solveInPlace(x[column]);
    for (std::size_t at = first_[column] + 1; at < first_[column + 1]; ++at)
      x[rows_[at]].noalias() -= blocks_[at] * x[column];
  }
  for (std::size_t column = x.size(); column-- > 0;) {
    for (std::size_t at = first_[column] + 1; at < first_[column + 1]; ++at)
      x[column].noalias() -= blocks_[at].transpose() * x[rows_[at]];
    blocks_[first_[column]].triangularView<Eigen::Lower>().transpose().solveInPlace(x[column]);
  }
  for (std::size_t camera = 0; camera < right.size(); ++camera) right[camera] = x[order_[camera]];
}

/// The columns after it are inverted already.
void CameraSystem::invert_column(std::uint32_t column, std::vector<Mat6>& inverse) const {
  const std::size_t begin = first_[column] + 1, end = first_[column + 1];
  const auto factor = blocks_[first_[column]].triangularView<Eigen::Lower>();
  std::vector<Mat6> scaled(blocks_.begin() + static_cast<std::ptrdiff_t>(begin),
                           blocks_.begin() + static_cast<std::ptrdiff_t>(end));
  for (Mat6& block : scaled) factor.solveInPlace<Eigen::OnTheRight>(block);
  for (std::size_t b = begin; b < end; ++b) {
    std::size_t a = b;
    for (std::size_t at = first_[rows_[b]]; at < first_[rows_[b] + 1] && a < end; ++at) {
      if (rows_[at] != rows_[a]) continue;
      subtract_product(inverse[at], scaled[b - begin], inverse[a]);
      if (a != b) subtract_product(inverse[at].transpose(), scaled[a - begin], inverse[b]);
      ++a;
    }
  }
  Mat6 diagonal = Mat6::Identity();
  factor.solveInPlace(diagonal);
  factor.transpose().solveInPlace(diagonal);
  for (std::size_t a = begin; a < end; ++a) diagonal.noalias() -= scaled[a - begin].transpose() * inverse[a];
  inverse[first_[column]] = diagonal;
}

std::vector<Mat6> CameraSystem::inverse_diagonal() const {
  std::vector<Mat6> inverse(blocks_.size(), Mat6::Zero());
  with_widest_vectors([&] {
    for (std::size_t column = order_.size(); column-- > 0;) invert_column(static_cast<std::uint32_t>(column), inverse);
  });
  std::vector<Mat6> diagonal(order_.size());
  for (std::size_t camera = 0; camera < order_.size(); ++camera) diagonal[camera] = inverse[first_[order_[camera]]];
  return diagonal;
}

}  // namespace ilp::model

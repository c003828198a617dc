#include "fluid/images.h"

#include <algorithm>
#include <numeric>

#include "fluid/pool.h"

namespace feder {
namespace {

constexpr Real kCorner = Real(0.7);     // cosine between two planes, up to which the image of an image counts
constexpr Real kOpposite = Real(-0.7);  // cosine between normals, up to which particles are on the same side of a solid
constexpr Real kFarFace = Real(1e9);    // m

}  // namespace

BoundaryImages::BoundaryImages(Arena& a)
    : faces_(&a), shapes_(&a), moved_(&a), pushes_(&a), nearest_(&a), block_first_(&a), block_count_(&a), sums_(&a),
      back_(&a), there_(&a) {}

// Distances from the solids, and where the blocks of each particle go.
void BoundaryImages::place_faces(const FluidPool& p, const Boundary& boundary, JobPool& jobs) {
  const std::uint32_t contacts = p.contact_first[p.count], room = p.capacity() + 1;
  if (nearest_.size() < room)
    nearest_.resize(room), block_first_.resize(room), block_count_.resize(room), sums_.resize(room);
  if (pushes_.size() <= contacts) {
    const std::size_t more = contacts + contacts / 4 + 1;
    pushes_.resize(more), faces_.resize(more), shapes_.resize(more), moved_.resize(ImageInput::kPush * more);
  }
  jobs.for_blocks(p.count, kParticleGrain, [&](std::uint32_t first, std::uint32_t last, int) {
    for (std::uint32_t i = first; i < last; ++i) {
      Real nearest = p.support;
      for (std::uint32_t c = p.contact_first[i]; c < p.contact_first[i + 1]; ++c) {
        const BoundaryContact& k = p.contacts[c];
        const Real distance = std::max(k.distance(p.x[i].vec()), Real(0));
        faces_[c] = {k.normal[0], k.normal[1], k.normal[2], distance};
        shapes_[c] = k.shape;
        nearest = std::min(nearest, distance);
      }
      nearest_[i] = nearest;
      block_first_[i] = nearest < p.support ? (p.lists.count[i] + kLanes - 1) / kLanes : 0;
    }
  });
  std::exclusive_scan(block_first_.begin(), block_first_.begin() + p.count + 1, block_first_.begin(), 0u);
  const std::uint32_t most = block_first_[p.count];
  if (back_.size() < most) back_.resize(most + most / 2), there_.resize(back_.size());
  faces_[contacts] = {0, 0, 0, kFarFace};

  ImageInput& in = input_;
  in.faces = &faces_[0].x, in.shapes = shapes_.data(), in.first = p.contact_first.data();
  in.nearest = nearest_.data(), in.counts = p.lists.count.data();
  in.shares = p.uneven() ? p.share.data() : nullptr;
  in.far_face = contacts, in.far_particle = p.count;
  in.support = p.support, in.corner = kCorner, in.opposite = kOpposite;
  in.moments = std::any_of(boundary.bodies.begin(), boundary.bodies.end(),
                           [](const BoundaryBody& b) { return b.dynamic || !b.angular_velocity.isZero(0); });
  in.block_first = block_first_.data(), in.block_count = block_count_.data(), in.back = back_.data(),
  in.there = there_.data();
  in.sums = sums_.data(), in.pushes = moved_.data();
}

void BoundaryImages::build(const FluidPool& p, const Boundary& boundary, JobPool& jobs) {
  value_factor_ = p.value_factor, slope_factor_ = p.slope_factor;
  place_faces(p, boundary, jobs);
  const SweepInput sweep = p.sweep_input();
  jobs.for_blocks(p.count, kFluidGrain, [&](std::uint32_t first, std::uint32_t last, int) {
    p.sweeps->images(sweep, input_, first, last);
    for (std::uint32_t c = p.contact_first[first]; c < p.contact_first[last]; ++c) {
      const Real* moved = &moved_[ImageInput::kPush * c];
      const Vec3 linear = slope_factor_ * vec3(moved[0], moved[1], moved[2]);
      const Vec3 arm = p.x[p.contacts[c].particle].vec() - boundary.body_of(p.contacts[c]).center;
      pushes_[c] = {linear, cross(arm, linear) - slope_factor_ * vec3(moved[3], moved[4], moved[5])};
    }
  });
}

}  // namespace feder

// The parts of contact that its files share. Private to the module.
#pragma once
#include <memory>
#include <vector>

#include "base/checks.h"
#include "contact/flat_parts.h"
#include "contact/near_search.h"
#include "contact/surface_contact.h"
#include "state/contact_book.h"
#include "state/surface_links.h"

namespace feder {

struct Tangles;

// Impact zone: points that the non-penetration projection moves as one (non_penetration.cpp).
struct Zone {
  Vec3 velocity = Vec3::Zero();  // their momentum while it is summed up, m/s
  Real mass = 0;
  Real share = 1;     // of the displacement by that velocity that the search allows
  Real freedom = 1;   // share of its points' motion relative to it that keeps its pairs apart
  bool held = false;  // it contains a pinned point: its velocity is zero
};

struct SurfaceContact::Impl {
  explicit Impl(SystemSetup& setup);

  Arena& arena;
  Store& store;
  Objects& objects;
  ContactBook& contacts;
  bool* structure_changed;
  const std::uint32_t finder;
  Surfaces& surfaces;
  // members of `surfaces`
  Array<Surface>& list;
  Array<Vec3>& position;
  Array<Real>& mass;
  Array<Row4>&delta_position, &before, &velocity;
  Array<SurfacePair>& surface_pairs;
  std::vector<std::unique_ptr<NearSearch>> searches;  // by group
  JobPool* jobs = nullptr;                            // of this step
  const NearKernels* kernels = &kNearKernelsPlain;

  // groups.cpp
  Array<std::uint32_t> surface_of_body{&arena};  // by solver index: the first surface connected to it
  Array<std::uint32_t> joined_to{&arena};        // by surface: an earlier one of its group, or itself

  // proximity search and projection, by point; each group writes the entries of its own points
  Array<Aabb> vertex_box{&arena};                                // swept over the rest of the step, beside the drift
  Array<Vec3> search_position{&arena}, search_velocity{&arena};  // where the search extrapolates from, m, m/s
  Array<Row4> search_row{&arena}, search_way{&arena};            // the same, with max_deviation in w
  Array<Row4> now_row{&arena};                                   // positions at the start of the part, m
  Array<Real> max_deviation{&arena};          // by point: from that motion, as the search allows for, m
  Array<Real> allowed{&arena};                // by point: the part of it in this part, of a kept search, m
  Array<Row4> projection_start{&arena};       // displacements at the start of the part, m
  Array<std::uint32_t> zone_of{&arena};       // by point: a point of its zone, itself for the root; kNone: in no zone
  Array<Zone> zones{&arena};                  // by lowest point
  Array<Row4> saved_displacement{&arena};     // displacements before search_again() or the zones change them, m
  Array<Vec3> gained_momentum{&arena};        // by surface: angular momentum that its own rows left, kg m^2/s
  Array<Row4> saved_velocity{&arena};         // velocities while search_again() extrapolates along others, m/s
  Array<std::uint32_t> near_surface{&arena};  // by point: its surface
  std::uint64_t projected = 0, widened = 0;   // corrections and second searches of the last step
  std::uint64_t search_total = 0;             // searches of the last step, those included

  // Parts of surfaces with self-contact, by object; and of this search, by surface: null where all of it is searched.
  struct PartsOf {
    ObjectId object;
    std::unique_ptr<FlatParts> parts;
  };
  std::vector<PartsOf> all_parts;
  // Searches of surfaces that ask for one, by object; and of this search, by surface: null where there is none.
  struct SearchOf {
    ObjectId object;
    const Variant<BoxSearch>* kind;
    std::unique_ptr<BoxSearch> search;
  };
  std::vector<SearchOf> all_searches;
  Array<BoxSearch*> own_search{&arena};
  Array<Aabb> own_triangle_box{&arena}, own_edge_box{&arena};  // work memory of own_pairs.cpp
  Array<BoxPair> own_pairs{&arena};
  Array<FlatParts*> flat_parts{&arena};
  Array<unsigned char> sealed{&arena};  // by surface: 1: nothing of it can meet itself in this search
  Array<Real> bearable{&arena};         // by surface: deviation of its points that the search allows, m

  // tangles.cpp
  std::unique_ptr<Tangles> tangles;  // null: none were ever suspected
  bool any_tangled = false;          // in this step, by point: it belongs to an edge or a triangle that crosses
  Array<unsigned char> tangled{&arena};

  Array<Aabb> others_box{&arena};  // by surface: of those that it may be in contact with
  Array<Aabb> box{&arena};         // by surface
  double mismatch = 0, given = 0;  // N s, of the last step: largest sum of both sides' impulses; sum of impulses
  std::size_t pairs_seen = 0;      // candidate pairs of surfaces of the last step

  // links.cpp: points of surfaces held to each other, of this step
  struct HeldLink {
    std::uint32_t link = 0, a = 0, b = 0, p = 0, q = 0;  // in SurfaceLinks; surfaces; points of Surfaces
  };
  Array<HeldLink> held_links{&arena};
  // By point: `link_words` words of bits, of the links that it lies round; empty: there are none.
  Array<std::uint32_t> link_marks{&arena};
  std::uint32_t link_words = 0;
  Array<std::uint32_t> link_at{&arena}, next_at{&arena};  // work memory of mark_rings
  double link_gap = 0;                                    // m, the largest

  // Passes: of the step, of the substep, of the loop of solver substeps, of the step.
  void begin_step(StepContext& c);
  void list_pairs(StepContext& c);
  void form_groups(StepContext& c);
  void untangle(StepContext& c);
  void begin_substep(StepContext& c);
  void find_near(StepContext& c);
  void coast(StepContext& c);
  template <class F>
  void each_coasting(const SurfaceGroup& g, F&& f);
  void advance_bodies(StepContext& c);
  void solve_attachments(StepContext& c);
  void connect_links(StepContext& c);
  void solve_links(StepContext& c);
  void solve(StepContext& c);
  void read_velocities(StepContext& c);
  void rebound(StepContext& c);
  void project(StepContext& c);
  void finish(StepContext& c);

  // groups.cpp
  SurfaceGroup& group(const StepContext& c) const { return *surfaces.groups[static_cast<std::size_t>(c.inner.group)]; }
  NearSearch& search(const StepContext& c) const { return *searches[static_cast<std::size_t>(c.inner.group)]; }
  std::uint32_t first_of(std::uint32_t surface);
  void join(std::uint32_t a, std::uint32_t b);

  // links.cpp
  void sync_links();
  void mark_rings();
  std::string point_name(std::uint32_t point, ObjectId of) const;
  void warn_of_nothing(SurfaceLink& l, StepContext& c);
  bool linked(const std::uint32_t (&v)[4], bool edges) const;

  // rows.cpp
  void batch_rows(const SurfaceGroup& g, NearSearch& near) const;
  void solve_near(SurfaceGroup& g, NearSearch& near, Real h);
  void solve_row(SurfaceRow& r, bool near, Real h);
  void stop_rebound(SurfaceRow& r, bool near, Real h);
  void add_gained(const SurfaceRow& r, const Vec3 (&x)[4], const Vec3& total, const Real (&tilt)[4], Real scale);
  void remove_gained_momentum(const SurfaceGroup& g);
  void balance(const SurfaceRow& r, const Vec3 (&x)[4], const Vec3& total, Real push, Real (&tilt)[4]) const;
  Vec3 start(std::uint32_t vertex, Real h) const;  // where the solver substep of h began, m

  // tangles.cpp
  bool try_untangle(const Surface& s, Tangles& t, Real most, bool smooth);
  // of a NearCandidate or a NearPair
  bool tangled_pair(const auto& p) const {
    if (!any_tangled || p.surface_pair != kNone) return false;
    const std::uint32_t split = p.edges ? 2 : 1;
    unsigned char of[2] = {0, 0};
    for (std::uint32_t k = 0; k < 4; ++k) of[k >= split] |= tangled[p.v[k]];
    return of[0] != 0 && of[1] != 0;
  }

  // near.cpp: candidate pairs of features in this step, and their rows
  bool near_wanted(const SurfaceGroup& g) const;
  bool paired(std::uint32_t surface) const;  // it is in a candidate pair, whose surfaces are both in its group
  std::uint32_t surface_pair_of(std::uint32_t a, std::uint32_t b) const;  // kNone: they do not collide
  Vec3 current_position(std::uint32_t vertex) const { return position[vertex] + delta_position[vertex].vec(); }
  // `time`: rest of the step, s; `part`: from the making of rows to the projection, s; `held`: points may be held back
  // from the extrapolated motion by all of it.
  void find_pairs(const SurfaceGroup& g, NearSearch& near, Real time, bool held);
  void collect_pairs(const SurfaceGroup& g, NearSearch& near, Real time);
  void bound_others(const SurfaceGroup& g);
  FlatParts& parts_of(const Surface& s);
  BoxSearch* search_of(const Surface& s);  // own_pairs.cpp
  void find_own_pairs(NearSearch& near, std::uint32_t n, Real time);
  void measure_parts(const SurfaceGroup& g, Real time, bool held);
  // Whether a feature of surface n is searched for contact by trees.
  bool searched(std::uint32_t n, const Aabb& bounds) const {
    const Surface& s = list[n];
    return (s.active && s.self && !flat_parts[n] && !own_search[n]) || overlaps(bounds, others_box[n]);
  }
  // Whether the trees answer for two points: not within a surface that has parts or a search of its own.
  bool searched_together(std::uint32_t i, std::uint32_t j) const {
    return near_surface[i] != near_surface[j] || (!flat_parts[near_surface[i]] && !own_search[near_surface[i]]);
  }
  // Bounds of three points over the rest of the step; c may be b.
  Aabb box_of(std::uint32_t a, std::uint32_t b, std::uint32_t c) const {
    Aabb all = vertex_box[a];
    all.include(vertex_box[b]);
    if (c != b) all.include(vertex_box[c]);
    return all;
  }
  void list_features(const SurfaceGroup& g, NearSearch& near, Real time, bool held);
  void offer_pair(NearSearch& near, const std::uint32_t (&v)[4], bool edges, Real time);
  void test_offered(NearSearch& near, Real time);
  Real rest_distance(const NearCandidate& p) const;
  void list_pairs_of(NearSearch& near, bool all, Real part);
  void make_near_rows(SurfaceGroup& g, NearSearch& near, Real time, Real part);
  int search_count(const SurfaceGroup& g, StepContext& c) const;  // of a substep
  void collect_near(const SurfaceGroup& g);
  void account(const SurfaceRow& r, int k, const Vec3& change, const Vec3& wanted, Real h);
  // kept.cpp
  struct KeptImage {
    explicit KeptImage(Arena& a) : rest(&a) {}
    KeptOf of;
    std::uint32_t rows = 0;
    Array<Row4> rest;
  };
  std::vector<KeptImage> kept_images;  // of a snapshot, until the next step
  KeptOf kept_of(std::uint32_t group) const;
  bool sound(const KeptImage& image, const KeptOf& now) const;
  void check_kept();
  bool slow(const SurfaceGroup& g, const NearSearch& near, Real part) const;
  void choose_rest(const Surface& s, NearSearch& near, std::uint32_t k, bool again, Real part);
  void update_pairs(const SurfaceGroup& g, NearSearch& near, Real time, Real part);
  Real fresh_skin(const Surface& s, std::uint32_t k, Real part) const;
  bool kept_holds(NearSearch& near, Real part);
  bool search_part(const SurfaceGroup& g, NearSearch& near, Real time, Real part);
  void collect_kept(const SurfaceGroup& g, NearSearch& near, Real time);
  bool in_reach(const NearCandidate& p) const;
  void save_kept(Writer& w) const;
  void load_kept(Reader& r);
  // non_penetration.cpp
  void project_pairs(const SurfaceGroup& g, NearSearch& near, Real part);
  Vec3 deviation(const NearSearch& near, std::uint32_t vertex) const;  // from the extrapolated motion, m
  bool within_search(NearSearch& near, Real part);
  bool separate(NearPair& p, Real h, bool push);
  void project_out(const SurfaceGroup& g, NearSearch& near, Real part);
  Vec3 angular_momentum(const NearSearch& near) const;
  void move_zones(const NearSearch& near, Real part);
  Real freedom(const NearPair& p);
  void search_again(const SurfaceGroup& g, NearSearch& near, Real part, bool held);
  std::uint32_t zone_root(std::uint32_t vertex);

  // surface_contact.cpp
  void wake_left();
  Aabb swept_bounds(const Surface& s, StepContext& c) const;
  void report(const SurfacePair& k);
  void wake(ObjectId sleeper, ObjectId other);
  // validate.cpp
  void validate_group(std::size_t k) const;
};

}  // namespace feder

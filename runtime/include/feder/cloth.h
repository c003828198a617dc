// Cloth: sheets of triangles with stretch, shear and bending stiffness, thickness and friction. Each cloth has a solver
// of its own. Cloths are surfaces of contact: in a step their vertices are its first points, with the same indices.
// Units: stretch and shear in N/m (force per width and strain: E h for a sheet of thickness h), bend in N m
// (E h^3 / (12 (1 - nu^2)), moment per width and curvature). One thread at a time, that of the world.
#pragma once
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "feder/system.h"

namespace feder {

struct ClothVertices;

inline constexpr ObjectKind kClothKind{"cloth", "cloths"};
inline constexpr WakeCause kClothCause{"cloth"};
inline constexpr EventKind kTear{"tear", EventKind::kPlace | EventKind::kForce};

std::string default_cloth_solver();

struct ClothDesc {
  std::string name;
  TagMask tags = 0;
  // A sheet of nx x ny vertices, size[0] along x and size[1] along z, in the xz plane; row 1 ("top") at the lowest z,
  // column 1 ("left") at the lowest x. Or, when nx is 0, a mesh.
  Real size[2] = {1, 1};  // m
  std::uint32_t nx = 0, ny = 0;
  std::vector<Vec3> vertices;            // m, local
  std::vector<std::uint32_t> triangles;  // three vertex numbers each
  Pose pose;
  Vec3 velocity = Vec3::Zero();   // m/s
  Real area_density = Real(0.2);  // kg/m^2
  Real stretch = 2000;            // N/m
  Real shear = -1;                // N/m; < 0: a tenth of the least of stretch, warp and weft (sheets only)
  // Stretch stiffness along the warp threads and across them, N/m; < 0: stretch. Warp runs along x of a sheet, and of a
  // mesh along warp_axis (local, any length above 0).
  Real warp = -1, weft = -1;
  Vec3 warp_axis = Vec3(1, 0, 0);
  Real bend = Real(1e-4);       // N m
  Real damping = Real(0.002);   // s: stress of strain rate over stiffness; never acts on rigid motion
  Real thickness = Real(0.01);  // m, between two layers; half of it to bodies
  Real friction = Real(0.4);
  bool self_collision = true;
  // What crosses itself: "guard" keeps it from crossing more and leads it out; "ignore" leaves it to the material, with
  // neither contact nor friction between the parts that cross. With more crossings than edges, both have no contact
  // with itself until there are half as many. What does not come apart is reported by the warning `tangled`.
  std::string inside = "guard";
  std::string self;              // what finds candidates of self-contact: of box_searches(), "swept_boxes" when empty
  bool wind = true;              // forces that act on areas (wind) act on it
  Real drag = 1, lift = 1;       // shares of the pressure along the flow and across it
  Real tear_strain = kInfinity;  // an edge stretched more than this breaks
  // Strain limit of edges; kInfinity: none. < 0: kMaxStrain where the cloth has pins or attachments, and none for cloth
  // that tears or flows.
  Real max_strain = -1;
  Real gravity_scale = 1;
  std::uint32_t group = 1, mask = 0xffffffffu;
  // Solver substeps per substep of the world: 0 chooses them so that a hanging sheet keeps stretch_error, see step.cpp.
  int substeps = 0;
  // Strain error of sweeps alone, beside the material's strain. < 0: 0.01; for cloth that bears nothing and that ties
  // to its pins hold 0.05 from 2500 vertices on, (n/2500)^(3/2) of it for n of them; with long links (xpbd), n/3500 of
  // it beyond that, 12 times at most. They leave a quarter of it.
  Real stretch_error = -1;
  // Largest number that is chosen, with a warning. 0: 64; in proportion more for less than 2500 vertices, up to 1000,
  // but not for what lies on them.
  int max_substeps = 0;
  std::string solver = default_cloth_solver();  // xpbd, or the first of this build
  Params solver_options;
  // Names: "top_left" "top_right" "bottom_left" "bottom_right" "top" "bottom" "left" "right", each with "_clamped"
  // when the slope is clamped too (sheets only); and vertex indices from 0.
  std::vector<std::string> pin_names;
  std::vector<std::uint32_t> pins;
  Real pressure = 0;  // Pa: of the gas in a closed mesh over that outside, whatever its volume
  // Plastic flow: strain beyond `yield` goes over into the rest lengths at the rate `flow`, 1/s; likewise that of
  // bending at the faces of the cloth, thickness/2 times curvature, into the rest angles. kInfinity: elastic.
  Real yield = kInfinity, flow = 0;

  // Calls f(field) for all of them, in this order.
  template <class D, class F>
  static void each_field(D& d, F&& f) {
    f(d.name), f(d.tags), f(d.size), f(d.nx), f(d.ny), f(d.vertices), f(d.triangles), f(d.pose), f(d.velocity);
    f(d.area_density), f(d.stretch), f(d.shear), f(d.bend), f(d.damping), f(d.thickness), f(d.friction);
    f(d.self_collision), f(d.inside), f(d.self), f(d.wind), f(d.drag), f(d.lift), f(d.tear_strain), f(d.max_strain),
        f(d.gravity_scale);
    f(d.group), f(d.mask), f(d.substeps), f(d.stretch_error), f(d.max_substeps), f(d.solver), f(d.solver_options);
    f(d.pin_names), f(d.pins), f(d.warp), f(d.weft), f(d.warp_axis), f(d.pressure), f(d.yield), f(d.flow);
  }
};

class Cloth final : public System {
 public:
  static constexpr const char* kName = "cloth";
  static const SystemDescriptor& descriptor();
  static constexpr Real kMaxStrain = Real(0.05);
  explicit Cloth(SystemSetup& setup);
  ~Cloth() override;

  void add_passes(StepPlan& plan) override;
  std::size_t count() const override;  // vertices
  void hash(Hash& h) const override;
  void save(Writer& w) const override;
  void load(Reader& r) override;
  Energy energy(const Vec3& gravity) const override;
  Momentum momentum() const override;
  void residuals(std::vector<Residual>& out) const override;
  bool finite() const override;
  void validate() const override;
  double held(const StepContext& c) override;

  ObjectId add_cloth(const ClothDesc& desc);  // SceneError on impossible input, nothing changed
  void destroy_cloth(ObjectId cloth, std::string where);
  std::size_t vertex_count(ObjectId cloth) const;
  std::size_t triangle_count(ObjectId cloth) const;
  std::size_t edge_count(ObjectId cloth) const;
  // The vertices of a side or corner of a sheet, "top_left"; SceneError for other names and for meshes.
  std::vector<std::uint32_t> named(ObjectId cloth, const std::string& name) const;
  // i counts from 0 within the cloth; SceneError when out of range.
  Vec3 point(ObjectId cloth, std::size_t i) const;
  void set_point(ObjectId cloth, std::size_t i, const Vec3& x);  // moves a pinned vertex, teleports a free one
  Vec3 velocity(ObjectId cloth, std::size_t i) const;
  void set_velocity(ObjectId cloth, std::size_t i, const Vec3& v);
  void apply_impulse(ObjectId cloth, std::size_t i, const Vec3& impulse);
  Real point_mass(ObjectId cloth, std::size_t i) const;
  void pin(ObjectId cloth, std::size_t i);
  void unpin(ObjectId cloth, std::size_t i);
  bool pinned(ObjectId cloth, std::size_t i) const;
  Real strain(ObjectId cloth, std::size_t k) const;  // of an edge
  Real max_strain(ObjectId cloth) const;             // the largest elongation / rest length of all edges
  // Edges that pass through triangles of the same cloth with which they share no vertex, counted by pairs; touching
  // does not count (geom/predicates.h).
  std::size_t tangles(ObjectId cloth) const;
  // m^3, within a closed mesh, whichever way its triangles are wound; holes of an open one count as closed by cones to
  // the mean of the vertices.
  double volume(ObjectId cloth) const;
  Real pressure(ObjectId cloth) const;  // Pa, as set
  void set_pressure(ObjectId cloth, Real pressure);
  void positions(ObjectId cloth, std::vector<Vec3>& out) const;
  void normals(ObjectId cloth, std::vector<Vec3>& out) const;           // by the angles at the vertex, unit
  void smooth_positions(ObjectId cloth, std::vector<Vec3>& out) const;  // for drawing only
  void triangles(ObjectId cloth, std::vector<std::uint32_t>& out) const;
  void set_script_force(ObjectId cloth, std::size_t i, const Vec3& force);  // N, until changed
  void clear_script_forces();
  int substeps(ObjectId cloth) const;  // solver substeps per world substep, as last chosen
  bool asleep(ObjectId cloth) const;
  void wake(ObjectId cloth, WakeCause cause = WakeCause::script, ObjectId other = {});
  void sleep(ObjectId cloth);
  bool quarantined(ObjectId cloth) const;

  struct Attachment {
    ObjectId cloth, body;
    std::uint32_t vertex = 0;   // index in ClothVertices
    Vec3 local = Vec3::Zero();  // in the body frame of `body`, m
  };
  void attach(ObjectId cloth, std::size_t i, ObjectId body, const Vec3& local);
  // To point j, from 0, of another soft thing (cloth, a net that collides, a rope, a soft body); from both sides.
  void attach_point(ObjectId cloth, std::size_t i, ObjectId other, std::size_t j);
  void detach(ObjectId cloth, std::size_t i);  // of all
  void detach_body(ObjectId body);
  const std::vector<Attachment>& attachments() const;

  // For couplings. Cloths are numbered 0 .. cloth_count()-1, in the order of their making.
  struct Info {
    ObjectId object;
    std::uint32_t first = 0, count = 0;        // visible run in ClothVertices
    std::span<const std::uint32_t> triangles;  // three numbers each, from 0 within the cloth
    Real thickness = 0, friction = 0;
    Real relaxation = 1;  // of contacts, as its solver wants it
    std::uint32_t group = 1, mask = 0xffffffffu;
    bool asleep = false;
    bool moving = false;  // awake, and no sleep candidate
  };
  std::size_t cloth_count() const;
  Info info(std::size_t n) const;  // of the n-th cloth
  const ClothVertices& vertices() const;
  // Load: the mass that rests on a cloth or hangs from it, kg; more solver substeps are chosen for it. Reset at the end
  // of each step while the cloth is awake, and set again by couplings. They limit resting mass to kMaxLoad times the
  // cloth's own: a heavier stack is carried by something below.
  static constexpr Real kMaxLoad = 50;
  void set_load(std::size_t n, Real mass);
  Real load(std::size_t n) const;
  // What approaches in this step: the acceleration that it would give to the whole cloth, m/s^2, and the approach speed
  // of bodies, m/s. The largest of several calls counts.
  void set_impact(std::size_t n, Real acceleration, Real speed);
  void set_beside_body(std::size_t n);                   // bodies, fixed ones too, may touch it in this step
  void push(std::uint32_t vertex, const Vec3& impulse);  // N s; after the solver substeps of a substep

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace feder

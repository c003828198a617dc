// A world: systems made on demand, the step plan they fill, the objects of scripts, and the events of a step. It knows
// no particular system. Nothing in a step allocates after warm-up, throws or logs. Threads: a world, its systems and
// all they return belong to one thread at a time; WorldDesc::threads are its own workers, and results do not depend on
// their number. Two worlds share only shapes, which are immutable.
#pragma once
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "feder/force.h"
#include "feder/params.h"
#include "feder/system.h"

namespace feder {

// Description of a world. Plain data: World's constructor checks it (SceneError names the field).
struct WorldDesc {
  Vec3 gravity = Vec3(0, Real(-9.81), 0);  // m/s^2
  double dt = 1.0 / 60.0;                  // s per step, in (0, 1]
  int substeps = 4;                        // 1 .. 1000
  std::uint64_t seed = 1;
  int threads = 1;  // 1 .. 64; results do not depend on it
  bool sleeping = true;
  bool rebuild = false;  // in every step all that is kept beside the state is made anew: results do not depend on it
  int dimension = 3;     // 2: bodies move in the xy plane
  Params options;        // broad_phase, narrow_phase
  std::map<std::string, Params> systems;  // options per system: systems["rigid"] holds solver = "soft_step" ...

  // Calls f(field) for all of them, in this order.
  template <class D, class F>
  static void each_field(D& d, F&& f) {
    f(d.gravity), f(d.dt), f(d.substeps), f(d.seed), f(d.threads), f(d.sleeping), f(d.rebuild), f(d.dimension);
    f(d.options), f(d.systems);
  }
};

// SceneError naming the field when something is out of range.
void check(const WorldDesc& desc);

class Rng;
struct Watch;
class JobPool;

// Threads that a host has already (an engine's task system), in place of a world's own workers. They help, they are not
// relied on: help may come late, more often than asked or never, from any threads; the thread that steps then does all
// itself, and results are the same bits in every case. A Helper is what such a thread
// calls; it may be kept and copied freely, and outlive the world: it then finds nothing to do.
class Helper {
 public:
  explicit Helper(std::shared_ptr<JobPool> jobs) : jobs_(std::move(jobs)) {}
  // Takes blocks of the world's loops while there are any, and returns when there have been none for some
  // microseconds. True when it did something; false also when Executor::threads are at work already.
  bool help() const;

 private:
  std::shared_ptr<JobPool> jobs_;
};

struct Executor {
  int threads = 1;  // 1 .. 64: at most so many work at once, with the one that steps; in place of WorldDesc::threads
  // Asks for up to `helpers` calls of helper.help(), on any threads, soon. It comes from the thread that steps or from
  // one that helps; it must not block, throw, or call help() itself. Empty: the world makes its own workers.
  std::function<void(const Helper& helper, int helpers)> call;
};

struct SystemReport {
  std::string name;
  std::string units;                    // "bodies", "points" ...
  std::size_t count = 0;                // of them
  std::size_t bytes = 0;                // its arena
  std::vector<std::string> notes = {};  // what it chose
};

// Number of objects of a kind, and of the units that its system counts.
struct KindCount {
  ObjectKind kind;
  std::size_t count = 0;
  const SystemDescriptor* parts = nullptr;  // the system that counts their parts; null where objects are its units
  std::size_t part_count = 0;
};

class World final : private SystemFinder {
 public:
  // `catalog` lists the systems this host links; it must outlive the world. `executor`: threads of the host that help.
  World(const WorldDesc& desc, Catalog catalog, const Executor& executor = {});
  ~World() override;
  World(const World&) = delete;
  World& operator=(const World&) = delete;

  const WorldDesc& desc() const { return desc_; }
  double time() const { return time_; }  // s, simulated
  std::uint64_t step_count() const { return steps_; }
  void set_gravity(const Vec3& g);  // wakes no body: see Rigid::wake_all
  CommandLog& commands();           // of what is done to it between steps (feder/record.h)

  // The system with S::kName, made (with what it needs) on first use. SceneError when this host leaves it out.
  template <class S>
  S& need() {
    return static_cast<S&>(need_system(S::kName));
  }
  template <class S>
  S* find() {
    return static_cast<S*>(find_system(S::kName));
  }
  // The system if present, brought up to date with the state now (the passes at S::kQuery): for queries that read more
  // than its own arrays, such as raycasts and densities. SceneError inside a step.
  template <class S>
  S* query() {
    prepare_queries(S::kQuery);
    return find<S>();
  }
  // Brings what is asked at that rank, one of those between steps, up to date with the state.
  void prepare_queries(Rank rank);
  System& need_system(std::string_view name);
  // Systems of the catalog that this world does not have.
  std::vector<std::string> absent() const;
  Catalog catalog() const { return catalog_; }

  // One step of dt. Must not be called from inside a step.
  void step();

  Objects& objects() { return objects_; }
  const Objects& objects() const { return objects_; }
  Events& events() { return events_; }
  Store& store() { return store_; }
  Rng& rng();
  const StepPlan& plan();  // rebuilt when needed
  void reset_profile() { plan_.reset_counters(); }
  void clock_every(int iterations) { plan_.clock_every(iterations); }  // of loops, see feder/plan.h

  // Forces: made by kind name; the target is everything, objects with a tag, or one object.
  ObjectId add_force(std::string_view kind, const Params& options, ForceEntry target, std::string name, TagMask tags);
  // A force whose values a script writes between steps (target filled by the caller, force may be null).
  ObjectId add_force(ForceEntry entry, std::string name, TagMask tags);
  void remove_force(ObjectId force, std::string where);
  void set_force_enabled(ObjectId force, bool enabled);
  bool force_enabled(ObjectId force) const;

  // Health and conserved quantities, summed over the systems.
  Energy energy() const;
  Momentum momentum() const;
  std::vector<Residual> residuals() const;
  bool is_finite() const;
  std::uint64_t hash() const;  // FNV-1a over the systems' states

  std::vector<SystemReport> report() const;  // systems present, in the order they were made
  std::vector<KindCount> counts() const;     // of all kinds of the catalog, in its order
  std::size_t bytes() const;
  std::uint64_t allocations() const;  // since birth, of all arenas: constant while only stepping

  // A byte image of the state; restore then run = run, bit for bit. Belongs to the world that made it.
  std::string snapshot() const;
  void restore(std::string_view image);  // SceneError, world unchanged, when it does not fit

 private:
  struct Present {
    const SystemDescriptor* descriptor;
    std::unique_ptr<System> system;
  };
  System* find_system(std::string_view name) override;
  struct Own;  // threads, scratch memory, random numbers
  const SystemDescriptor* find_descriptor(std::string_view name) const;
  System& make_system(const SystemDescriptor& descriptor);
  void make_couplings();
  void rebuild_plan();
  StepContext context();
  static void begin_step(void* self, StepContext& context);
  static void merge_contacts(void* self, StepContext& context);
  static void finish_step(void* self, StepContext& context);
  std::string save_image() const;
  void load_image(std::string_view image);
  void warn_of_forces();
  ForceEntry* find_force(ObjectId force) const;
  void warn_of_energy(const StepContext& c);  // watch.cpp
  // validate.cpp, where asserts are on
  void check_names() const;  // of a new plan
  void validate() const;     // after each step

  WorldDesc desc_;
  Catalog catalog_;
  std::unique_ptr<CommandLog> commands_;
  Store store_;
  Watch& watch_;
  Objects objects_;
  Events events_;
  std::unique_ptr<Own> own_;
  std::vector<Present> systems_;
  StepPlan plan_;
  Params no_options_;
  bool structure_changed_ = true;
  bool stepping_ = false;
  double time_ = 0;
  std::uint64_t steps_ = 0;
};

// All systems of this build, in the order of their modules: couplings come after the systems that they join. In a
// library of its own (feder::catalog), because it links them all; a host that wants fewer gives World a list of its
// own.
Catalog catalog();

}  // namespace feder

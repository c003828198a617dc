// Bullet's soft body as Debian packages it: a patch with diagonals, links of full stiffness (its default), and links
// over two that stand for bending, as in its own examples. One solver iteration of a frame by default.
#include <BulletSoftBody/btSoftBodyHelpers.h>
#include <BulletSoftBody/btSoftBodyRigidBodyCollisionConfiguration.h>
#include <BulletSoftBody/btSoftRigidDynamicsWorld.h>
#include <btBulletDynamicsCommon.h>

#include "sheet.h"

namespace rivals {
namespace {

btVector3 to(Vec v) { return {v.x, v.y, v.z}; }

class BulletSheet final : public SheetEngine {
 public:
  BulletSheet(const SheetScene& scene, const SheetSettings& settings)
      : dt_(scene.dt), substeps_(settings.substeps > 0 ? settings.substeps : 1) {
    const btVector3 gravity(0, scene.gravity, 0);
    world_.setGravity(gravity);
    world_.getWorldInfo().m_gravity = gravity;
    const int n = scene.side_vertices, end = n - 1;
    constexpr int kFirstCorners = 1 + 2;  // of the row that corner00 and corner10 end: fixed
    soft_ =
        btSoftBodyHelpers::CreatePatch(world_.getWorldInfo(), to(scene.corner(0, 0)), to(scene.corner(end, 0)),
                                       to(scene.corner(0, end)), to(scene.corner(end, end)), n, n, kFirstCorners, true);
    links_ = soft_->m_links.size();
    soft_->generateBendingConstraints(2);
    if (settings.iterations > 0) soft_->m_cfg.piterations = settings.iterations;
    soft_->setTotalMass(scene.mass());
    soft_->setActivationState(DISABLE_DEACTIVATION);
    world_.addSoftBody(soft_);
  }
  ~BulletSheet() override {
    world_.removeSoftBody(soft_);
    delete soft_;
  }

  void frame() override {
    for (int k = 0; k < substeps_; ++k) world_.stepSimulation(dt_ / static_cast<btScalar>(substeps_), 0);
  }

  Rows rows() const override {
    return {links_, soft_->m_links.size() - links_, static_cast<double>(substeps_) * soft_->m_cfg.piterations};
  }

  void positions(std::vector<Vec>& out) const override {
    out.clear();
    for (int i = 0; i < soft_->m_nodes.size(); ++i) {
      const btVector3& x = soft_->m_nodes[i].m_x;
      out.push_back({static_cast<float>(x.x()), static_cast<float>(x.y()), static_cast<float>(x.z())});
    }
  }

 private:
  btScalar dt_;
  int substeps_;
  btSoftBodyRigidBodyCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_{&configuration_};
  btDbvtBroadphase broadphase_;
  btSequentialImpulseConstraintSolver solver_;
  btSoftRigidDynamicsWorld world_{&dispatcher_, &broadphase_, &solver_, &configuration_};
  btSoftBody* soft_ = nullptr;
  long links_ = 0;
};

}  // namespace

const char* const kSheetEngineName = "bullet";
std::unique_ptr<SheetEngine> make_sheet(const SheetScene& scene, const SheetSettings& settings) {
  return std::make_unique<BulletSheet>(scene, settings);
}

}  // namespace rivals

import hardlimit as hl, warnings, time, sys
warnings.simplefilter("ignore")
s=hl.ParticleSystem.random(20,.1,(.008,.01),2500.,1.,seed=3)
for m in (3000,5000,8000,12000):
    t=time.time(); r=hl.event_driven(s,restitution=.3,rule="tc",contact_duration=1e-6,max_collisions=m)
    print(m,r.outcome[:9],r.n_collisions,r.time,r.series.kinetic_energy.values[-1]/r.series.kinetic_energy.values[0],len(r.series.time),time.time()-t,flush=True)

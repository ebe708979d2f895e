"""temporary: bias with many fresh maps"""
import sys, json
sys.path.insert(0,'bench')
import numpy as np
import blind_fit as b
from hdengine.surfaces import roughness
SEED=51000
import zlib
old=json.load(open('bench/results/blind_fit.json'))['maps']
first=[k for k,v in old.items() if abs(v['bias'])>.02]
rest=[k for k in old if k not in first]
out=open('/tmp/h/w35_bias.jsonl','a')
for key in first+rest:
    name,d=key.split(', D = '); d=float(d)
    make=b.maker(name,128,d)
    es=[]
    for s in range(500):
        rng=np.random.default_rng([SEED,zlib.crc32(f"{key}".encode()),s])
        f=roughness.fit(*make(rng))
        es.append(f.fractal_dimension-d)
        out.write(json.dumps([key,s,f.fractal_dimension,f.interval[0],f.interval[1],f.verdict,f.kind,f.probe_m,f.noise_m,f.finer_detail,f.band_m,f.chi2,f.freedom])+'\n')
        if s>=59 and np.std(es,ddof=1)/np.sqrt(len(es))<.007: break
    out.flush()
    print(key,len(es),np.mean(es),np.std(es,ddof=1)/len(es)**.5,flush=True)

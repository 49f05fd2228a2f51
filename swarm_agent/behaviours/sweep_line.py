"""Prototype: sweep lines."""
import cmath, math
import msgspec
import numpy as np
from wire.clearing import Standing
from wire.messages import Shift
from swarm_agent.behaviour import Behaviour, Move, Parameters as Base
from swarm_agent.geometry import clearance_m, nearest, roll, shortened, turn_rad, unit, NOTHING
from swarm_agent.peers import Eye, Peers, number
from swarm_agent.sweep_radio import Beacon, Flow, WALL, NOBODY
from swarm_agent.surveillance_graph import SurveillanceGraph
from swarm_agent.graph_copy import NOTHING as NO_VERSION


DEAD=6
class Parameters(Base):
    follow_m: float = 1.0
    obstacle_m: float = 0.25
    team: int = 0
    restarts: int = 6
    patience: int = 2500
    def settled(self, team_size):
        return self if self.team else msgspec.structs.replace(self, team=team_size-1)

class SweepLine(Behaviour):
    Parameters = Parameters
    Radio = Beacon
    def __init__(self, parameters, configuration, generator):
        super().__init__(parameters, configuration, generator)
        c=configuration
        self.eye=Eye(c.field.rays, c.field.detect_m); self.me=number(c.node)
        self.peers=Peers(self.me,self.eye); self.graph=SurveillanceGraph(c.node)
        self.step_m=c.max_speed_m_s*c.tick_s; self.body=c.body_m
        self.reach=c.field.detect_m-self.step_m/2-0.02
        self.role='free'; self.left=self.right=NOBODY; self.old=set(); self.line=0; self.since=-1
        self.contact=0j; self.pinned=self.halt=self.close=self.ready=False; self.stage=''
        self.wall=0j; self.moved=0; self.ahead=0; self.rank=9999; self.tail=1; self.crumbs=[]; self.wait=0
        self.from_left=self.from_right=None; self.in_left=self.in_right=None; self.angle=0.; self.open=True
        self.event=''; self.claim=''; self.hand='left'; self.target=0; self.born=None; self.wanted=(False,0,0,0); self.order=0; self.taut=0; self.rounds=0; self.pushed=0; self.order_since=0; self.still_since=0; self.place=0; self.beside='left'; self.epoch=0; self.anchor=0; self.courier=0; self.dead=set(); self.left_anchor=False; self.gathered=0; self.restarts=0; self.turns=[]; self.walked=0.; self.aim=0j; self.main_since=0; self.nearest_m=9.; self.nearer=0; self.obstacle=None
    def describe(self):
        return dict(role=self.role,l=self.left,r=self.right,old=self.old,line=self.line,halt=self.halt,pin=self.pinned,close=self.close,ready=self.ready,open=self.open,ahead=self.ahead,rank=self.rank,tail=self.tail,ang=round(math.degrees(self.angle)),moved=self.moved,stage=self.stage,il=self.in_left and (self.in_left.count,self.in_left.moved,self.in_left.open,self.in_left.halt),ir=self.in_right and (self.in_right.count,self.in_right.moved,self.in_right.open,self.in_right.halt),claim=self.claim,g=(self.graph.version.events,self.graph.main))
    # ------------------------------------------------------------- step
    def step(self, percept, heard):
        self.tick=percept.tick
        if self.born is None: self.born=percept.tick
        s=percept.senses
        self.peers.take(percept.tick, complex(*s.odometry_m), heard)
        self.gone_peers={n:p for n,p in self.peers.known.items() if self.tick-p.tick>DEAD}
        self.known={n:p for n,p in self.peers.known.items() if self.tick-p.tick<=DEAD}
        self.peers.known=self.known
        self.here=self.peers.here
        self.ranges=np.frombuffer(s.scan,'<f4').astype(float)
        seen=np.isfinite(self.ranges)
        self.hits=self.here+self.ranges[seen]*self.eye.units[seen]
        self._margins={}
        for p in self.known.values():
            if p.beacon.delta is not None: self.graph.take(p.beacon.delta)
        self.event=''
        self._epochs()
        if self.role in('leader','centre','join','leave'):
            self._links()
        if self.role in('leader','centre','join','leave'):
            self._look(); self._flows(); self._events()
        self._flows_out()
        way=self._motion()
        if abs(way)>1e-6:
            self.moved=self.tick
        return Move(motion=Shift(way.real,way.imag), say=(self._beacon(),), wake_tick=self.tick+1, report=self._standing())
    def _beacon(self):
        old=[p.beacon.version for p in self.known.values() if p.beacon.version<self.graph.version]
        delta=self.graph.delta_since(min(old)) if old else None
        w=(self.contact if self.role=='leader' else self.wall)-self.here
        return Beacon(self.role,self.line,self.since,self.left,self.right,self.ahead,self.rank,self.tail,self.eye.packed(self.ranges),self.peers.measured,self.from_left,self.from_right,self.pinned,self.close,self.ready,w.real,w.imag,self.graph.version,delta,self.stage,self._wants() if self.on_line else False,self.epoch,self.anchor,self.courier,tuple(sorted(self.dead)))
    def _standing(self):
        name=lambda n: 'wall' if n==WALL else f'r{n}' if n>0 else ''
        kinds=tuple(k for k in('split','search failed','search','dissolve') if self.event.startswith(k))[:1]
        return Standing(role=self.role,line=max(self.line,0),main=self.is_main() and self.on_line,left=name(self.left),right=name(self.right),claim=self.claim,releasing=self.graph.main is None and not self.graph.lines(),events=tuple(k.replace(' ','_') for k in kinds))
    @property
    def on_line(self): return self.role in('leader','centre','leave')
    def peer(self,n): return self.known.get(n)
    # ------------------------------------------------------------- links
    def _walls(self,p):
        return np.concatenate((self.hits,p.hits(self.eye)))
    def _margin(self,a,b,walls):
        """how well the link a (left) - b (right) holds."""
        d=abs(b-a)
        if d<1e-9: return self.reach
        n=1j*(b-a)/d; mid=(a+b)/2; best=-9.
        for k in range(7):
            via=mid+n*0.08*k
            m=min(self.reach-abs(via-a), self.reach-abs(via-b))
            if m<=best: break
            m=min(m, clearance_m(walls,a,via)-0.06, clearance_m(walls,via,b)-0.06)
            best=max(best,m)
            if best>=self.step_m: break
        return best
    def _link(self,p,side,at=None):
        at=self.here if at is None else at
        w=self._walls(p)
        return self._margin(p.here,at,w) if side=='left' else self._margin(at,p.here,w)
    def _side_of(self,n):
        if n==self.left: return 'left'
        if n==self.right: return 'right'
        return self.old_side.get(n,'left')
    old_side={}
    def _links(self):
        if self.stage=='form':
            p=self.peer(self.right)
            if p is None or p.beacon.left!=self.me:
                if p is None or self.tick-self.wait>150: self._retry()
                return
            self.stage=''
        for n in list(self.old):
            p=self.peer(n)
            if p is None or (p.beacon.left!=self.me and p.beacon.right!=self.me): self.old.discard(n)
        if self.role=='join':
            a,b=self.peer(self.left),self.peer(self.right)
            if a and b and a.beacon.right==self.me and b.beacon.left==self.me: self.role='centre'; self.line,self.since=a.beacon.line,a.beacon.since; self.ahead=0;self.rank=9999
            elif self.tick-self.wait>12 or not a or not b or a.beacon.right not in(self.me,self.right) or b.beacon.left not in(self.me,self.left): self._to_file()
            return
        if self.role=='leave':
            a,b=self.peer(self.left),self.peer(self.right)
            if a and b and a.beacon.right==self.right and b.beacon.left==self.left: self._to_file(); return
            if self.tick-self.wait>12 : self.role='centre'
        for side in('left','right'):
            n=getattr(self,side)
            if n in(NOBODY,WALL): continue
            p=self.peer(n)
            if p is None: self._lost(side,n); return
            b=p.beacon
            back=b.right if side=='left' else b.left
            onward=b.left if side=='left' else b.right
            if back==WALL and b.stage=='closed' or b.role in('file','free') and b.stage=='gone':
                self._dissolved(); return
            if b.role=='leave' and self.role!='leave' and onward>0 and back==self.me:
                z=self.peer(onward)
                if z and self._link(z,side)>=self.step_m and abs(z.here-self.here)<=self.parameters.follow_m:
                    self._replace(side,n,onward)
                continue
            for x in self.known.values():
                xb=x.beacon
                if xb.role=='join' and (xb.left,xb.right)==((n,self.me) if side=='left' else (self.me,n)) and self.role!='leave':
                    if self._link(x,side)>=0.02 and not self.ready:
                        self._replace(side,n,x.number); break
            else:
                # neighbour not confirming: revert where it turned out to be no neighbour
                if back!=self.me and b.role in('file','free') :
                    # joiner gave up, or it left: find who names us
                    for z in self.known.values():
                        if z.beacon.role in('leader','centre','leave') and (z.beacon.right if side=='left' else z.beacon.left)==self.me and z.number!=n:
                            self._replace(side,n,z.number); break
                elif back not in(self.me,) and b.role in('leader','centre'):
                    for z in self.known.values():
                        if z.number!=n and z.beacon.role in('leader','centre') and (z.beacon.right if side=='left' else z.beacon.left)==self.me and self.tick-self.wait>6:
                            self._replace(side,n,z.number); break
            if b.since>self.since and back==self.me and b.role in('leader','centre'): self.line,self.since=b.line,b.since
        if self.role=='centre' and self.left>0 and self.right>0:
            a,b=self.peer(self.left),self.peer(self.right)
            if a and b and a.beacon.right==self.right and b.beacon.left==self.left: self._to_file(); return
    def _replace(self,side,n,new):
        self.old.add(n); self.old_side=dict(self.old_side); self.old_side[n]=side
        setattr(self,side,new)
    def _to_file(self):
        self.role='file'; self.line,self.since=-1,-1; self.left=self.right=NOBODY; self.old=set(); self.pinned=self.halt=self.close=self.ready=False; self.stage=''; self.crumbs=[]; self.ahead=0; self.rank=9999; self.hand='left'; self.from_left=self.from_right=None
        self.contact=nearest(self.hits,self.here) if len(self.hits) else self.here
    def _dissolved(self):
        h='left'
        self._to_file(); self.stage='gone'; self.gone=self.tick
    def _epochs(self):
        for p in self.known.values():
            b=p.beacon
            self.dead|=set(b.dead)-{self.me}
            if b.epoch>self.epoch or b.epoch==self.epoch and b.anchor and b.anchor<self.anchor:
                self.epoch,self.anchor,self.courier=b.epoch,b.anchor,b.courier
                self._to_file(); self.stage='gone'; self.claim=''; self.left_anchor=False
                if self.courier==self.me or p.number==self.courier: self.hand='right'
    def _restart(self,why):
        """All that was clear is lost: everybody gathers where I am, and the team begins again."""
        self.event='restart '+why
        if self.graph.main is not None: self.graph.release(None)
        for l in list(self.graph.lines()):
            if l in self.graph.lines(): self.graph.release(l)
        near=[p.number for p in self.known.values() if p.beacon.role!='free']
        self._to_file(); self.epoch+=1; self.anchor=self.me; self.courier=max(near,default=0); self.role='anchor'; self.stage='gather'
        self.gathered=self.tick; self.claim=''; self.walked=0.; self.turns=[]; self.restarts+=1
    def _lost(self,side,n):
        """A neighbour is silent for good."""
        old=self.gone_peers.get(n)
        self.dead.add(n); self.event='lost %d'%n
        if old is not None:
            onward=getattr(old.beacon,side)
            z=self.peer(onward) if onward>0 else None
            if z and self._link(z,side)>=0: self._replace(side,n,onward); self.old.discard(n); return
            if onward==WALL and self.role=='centre':
                w=old.here+old.turn*old.beacon.wall
                if self._sees(w): setattr(self,side,WALL); self.contact=w; self.role='leader'; self.stage=''; return
        if self.graph.main is None and not self.graph.lines(): self._to_file(); return
        self._restart('after %d'%n)
    # ------------------------------------------------------------- looking
    def _look(self):
        P=self.known
        def toward(n,side):
            p=P.get(n)
            if p is None: return 1+0j
            if abs(p.here-self.here)<1e-6: return 1+0j
            via=self._via(p.here,self.here,self._walls(p),p.here) if side=='left' else self._via(self.here,p.here,self._walls(p),p.here)
            return via-self.here
        lw=(self.contact-self.here) if self.left==WALL else toward(self.left,'left')
        rw=(self.contact-self.here) if self.right==WALL else toward(self.right,'right')
        self.lw,self.rw=lw,rw
        n=self.eye.rays
        first=self.eye.ray(lw); m=round(turn_rad(lw,rw,'right')/math.tau*n)
        idx=(first-np.arange(m+1))%n
        r=self.ranges[idx]; fin=np.isfinite(r)
        ends=self.here+np.where(fin,r,self.eye.detect_m)*self.eye.units[idx]
        crew=[p for p in P.values() if p.beacon.role in('leader','centre','leave')]
        def covered(pts):
            out=np.zeros(len(pts),bool)
            for p in crew: 
                if abs(p.here-self.here)<2*self.eye.detect_m: out|=p.sees(self.eye,pts)
            return out
        frontier=~fin & ~covered(ends)
        gaps=np.abs(np.diff(ends)); big=np.flatnonzero((gaps>0.12)&(fin[1:]|fin[:-1]))
        for k in big:
            t=np.array([.2,.4,.6,.8]); pts=ends[k]+t*(ends[k+1]-ends[k])
            if not covered(pts).all(): frontier[k]=True
        self.idx,self.fin,self.ends,self.frontier=idx,fin,ends,frontier
        # own wall of a leader
        own=np.zeros(len(idx),bool)
        if self.role=='leader':
            order=range(len(idx)) if self.left==WALL else range(len(idx)-1,-1,-1)
            last=None
            for k in order:
                if not fin[k] : 
                    if last is None and abs(self.eye.units[idx[k]]-unit(lw if self.left==WALL else rw))<0.2: continue
                    break
                if last is not None and abs(ends[k]-ends[last])>0.12: break
                own[k]=True; last=k
        self.own=own
        self.open=bool((frontier&~own).any()) if self.role!='leader' else bool(frontier.any())
        # obstacles ahead
        half=[self.here]
        if self.left>0: half.insert(0,self.here+shortened(lw,abs(P[self.left].here-self.here)/2 if self.left in P else 0.5))
        if self.right>0: half.append(self.here+shortened(rw,abs(P[self.right].here-self.here)/2 if self.right in P else 0.5))
        front=np.flatnonzero(fin&~own)
        self.obstacle=None
        if len(front):
            pts=ends[front]
            d=np.full(len(pts),9.)
            for a,b in zip(half[:-1],half[1:]):
                way=b-a; t=np.clip(((pts-a)*way.conjugate()).real/max(abs(way)**2,1e-12),0,1); d=np.minimum(d,np.abs(pts-a-t*way))
            k=int(d.argmin())
            # hits right at the side directions belong to walls behind
            if d[k]<=(0.5 if self.order>0 and self.order==self.place else self.parameters.obstacle_m+0.02): self.obstacle=front[k]
    # ------------------------------------------------------------- flows
    def _flows(self):
        l=self.peer(self.left) if self.left>0 else None; r=self.peer(self.right) if self.right>0 else None
        self.in_left=l.beacon.from_left if l and l.beacon.right==self.me else None
        self.in_right=r.beacon.from_right if r and r.beacon.left==self.me else None
    def _flows_out(self):
        if not self.on_line: self.from_left=self.from_right=None; return
        mine=dict(moved=self.moved,open=self.open,halt=self.halt,pinned=self.pinned or self.close)
        spare=self._spare(); want=self._wants()
        if self.left==WALL: self.from_left=Flow(1,angle_rad=self.angle,leader=self.me,spare=spare,want=want,taut=self.taut,**mine)
        elif self.in_left:
            f=self.in_left; self.from_left=Flow(f.count+1,max(f.moved,self.moved),f.open or self.open,f.halt or self.halt,f.pinned or mine['pinned'],f.angle_rad,f.spare+spare,f.leader,f.want or want,0,max(f.taut,self.taut))
        else: self.from_left=None
        if self.right==WALL: self.from_right=Flow(1,angle_rad=self.angle,leader=self.me,spare=spare,want=want,order=self.order,**mine)
        elif self.in_right:
            f=self.in_right; self.from_right=Flow(f.count+1,max(f.moved,self.moved),f.open or self.open,f.halt or self.halt,f.pinned or mine['pinned'],f.angle_rad,f.spare+spare,f.leader,f.want or want,f.order)
        else: self.from_right=None
    def _spare(self):
        return max((p.beacon.tail for p in self.known.values() if p.beacon.role=='file' and p.beacon.ahead==self.me),default=0)
    def _wants(self):
        """Is there a gap to our right that nobody of the line can fill?"""
        r=self.peer(self.right) if self.right>0 else None
        if r is None or r.beacon.left!=self.me or self.old or r.beacon.role=='leave' or self.role=='leave': return False
        d=abs(r.here-self.here)
        return r.beacon.right==WALL and (d>self.parameters.follow_m or r.beacon.close)
    @property
    def count(self):
        return 1+(self.in_left.count if self.in_left else 0)+(self.in_right.count if self.in_right else 0)
    def _whole(self):
        return (self.left==WALL or self.in_left is not None) and (self.right==WALL or self.in_right is not None)
    def quiet(self):
        if not self._whole() or self.old: return False
        m=max([self.moved]+[f.moved for f in(self.in_left,self.in_right) if f])
        return self.tick-m>2*self.count+4
    def halted(self):
        return self.halt or any(f.halt for f in(self.in_left,self.in_right) if f)
    def any_pinned(self):
        return self.pinned or self.close or any(f.pinned for f in(self.in_left,self.in_right) if f)
    # ------------------------------------------------------------- events
    def _events(self):
        main=self.is_main()
        if self.role=='leader' and self.right==WALL:
            if not self.open and (self.in_left is None or not self.in_left.open) and self.left!=WALL:
                self.halt=True
                if self.quiet() and self.in_left and not self.in_left.open:
                    self._finish(); return
            else:
                self.halt=False
        if self.role=='leader':
            self.close=self.obstacle is not None
            if self.right==WALL: self._command()
            else: self.order=self.in_right.order if self.in_right else 0
            return
        self.order=self.in_right.order if self.in_right else 0
        self.place=1+(self.in_left.count if self.in_left else 0)
        if self.order!=self.place: self.taut=0; self.pushed=self.tick
        if self.role!='centre': self.halt=False; return
        # ready: left neighbour pinned and we see its wall
        was,self.ready=self.ready,False
        for side,p,back in(('left',self.peer(self.left),'right'),('right',self.peer(self.right),'left')):
            if p is None: continue
            theirs=getattr(p.beacon,back)
            if p.beacon.pinned and theirs==self.me and (side=='left' or not self.pinned):
                w=p.here+p.turn*p.beacon.wall
                self.pinned=self.halt=False
                if self._sees(w):
                    self.ready=True; self.wall=w
                self.beside=side
            if theirs==WALL and p.beacon.stage=='cut' and was and self.beside==side:
                setattr(self,side,WALL); self.contact=self.wall; self.role='leader'; self.since=p.beacon.since
                self.line=p.beacon.line+(1 if side=='left' else -1); self.stage=''; self.ready=False; self.pinned=self.halt=False
                return
        if self.ready or any(p and p.beacon.pinned for p in(self.peer(self.left),)): return
        if self.obstacle is None:
            self.halt=False; 
            if self.pinned and not self._sees(self.wall): self.pinned=False
            if not self.pinned: return
        if self.obstacle is not None and not self.pinned:
            self.wall=complex(self.ends[self.obstacle]); self.halt=True
        if self.pinned and self.is_main():
            for side,p,theirs in(('right',self.peer(self.right),'left'),('left',self.peer(self.left),'right')):
                if p and p.beacon.ready and getattr(p.beacon,theirs)==self.me and not self.old and self._whole():
                    self._cut(side); return
        if self.quiet():
            kw=int(np.argmin(np.abs(self.ends-self.wall)+(~self.fin)*9))
            lo=(self.in_left.open) or bool(self.frontier[:kw].any()); ro=(self.in_right.open) or bool(self.frontier[kw:].any())
            if lo and ro: self.pinned=True; self.halt=False
            elif lo or ro:
                self.pinned=self.halt=False; self.role='leader'; self.contact=self.wall; self.stage='closed'
                if ro: self.left=WALL
                else: self.right=WALL
                self.event='shift'
    def _give(self,order):
        self.order=order; self.order_since=self.tick
    def _command(self):
        """Of a line's right leader: what to do when the line cannot go on."""
        if not self.is_main() or not self._whole() or self.left==WALL: self.order=0; self.main_since=self.tick; return
        f=self.in_left; n=self.count; now=self.tick-self.order_since
        if self.order!=0 and (self.any_pinned() or f.halt):
            self.order_since=self.tick
            if self.any_pinned() and self.order>0: self._give(0); self.rounds=0; self.event='found'
            return
        if self.order==0:
            if not self.quiet() or self.any_pinned() and not self._stuck_long(): 
                return
            spare=f.spare+self._spare()
            mine=self.graph.main.line
            coming=self.parameters.team-len(self.dead)-n-spare-sum(e.robots for l,e in self.graph.lines().items() if l!=mine)
            if self.tick-max(self.moved,f.moved,self.main_since)<=2*n+(30 if spare==0 and coming<=0 else 200 if coming<=0 else self.parameters.patience): return
            if n<3 or self.any_pinned(): self._fail(); return
            self.rounds+=1; self._give(-1); self.event='search %d'%self.rounds
        elif self.order==-1:
            c=self.peer(self.left); a=self.peer(c.beacon.left) if c and c.beacon.left>0 else None
            if a and abs(a.here-self.here)<=0.95: self._give(2)
            elif self.tick-max(self.moved,f.moved)>2*n+20 and now>2*n+20: self._fail()
            elif now>400: self._give(2)
        elif self.order>=2:
            if f.taut==self.order or now>200: 
                if self.order<n-1: self._give(self.order+1)
                elif self.rounds<2: self.rounds+=1; self._give(-1)
                else: self._fail()
        elif self.order==-2:
            if now>400 or self.quiet(): self._park()
    def _stuck_long(self):
        f=self.in_left
        return self.tick-max(self.moved,f.moved)>2*self.count+250
    def _fail(self):
        self.event='search failed'; self.rounds=0
        self._park()
    def _park(self):
        """What to do with a line that cannot go on."""
        self._give(0)
        n=self.parameters.team-len(self.dead)
        lines=self.graph.lines()
        held={l:e.robots for l,e in lines.items()}
        mine=self.count
        best=None
        for l,e in lines.items():
            free=n-mine-sum(h for k,h in held.items() if k!=l)
            need=self.graph.vertex(self.graph.ahead_of(l)).robots
            if free>e.robots and free>=need and (best is None or l>best): best=l
        if best is not None and self.graph._entries(self.graph.main.vertex):
            self.graph.park(n-sum(held.values())); self.graph.activate(best); self.line=max(self.graph.lines()); self.since=self.tick
            self.event='search failed; parked, next %d'%best; return
        if self.restarts<self.parameters.restarts: self._restart('elsewhere')
        else: self.claim='failed'
    def _sees(self,w):
        d=abs(w-self.here)
        if d>0.6: return False
        r=self.ranges[[self.eye.ray(w-self.here)-1,self.eye.ray(w-self.here),(self.eye.ray(w-self.here)+1)%self.eye.rays]]
        return bool(r.max()>=d-0.05)
    def _cut(self,side):
        nl=self.in_left.count+(side=='right'); nr=self.in_right.count+(side=='left')
        if True:
            l,rr=self.graph.split(nl,nr)
            self.graph.activate(l if nl>=nr else rr)
            self.line=l if side=='right' else rr
        self.since=self.tick
        setattr(self,side,WALL); self.contact=self.wall; self.role='leader'; self.stage='cut'; self.pinned=self.halt=False
        self.event='split'
    def _finish(self):
        self.event='dissolve'
        if self.is_main():
            self.graph.dissolve()
            if lines:=self.graph.lines(): self.graph.activate(max(lines)); self.event='dissolve; next %d'%max(lines)
        self._dissolved()
        if self.graph.main is None and not self.graph.lines(): self.claim='done'
    def is_main(self):
        return self.graph.main is not None and self.graph.main.line==self.line
    # ------------------------------------------------------------- motion
    def _motion(self):
        if self.role=='free': return self._form()
        if self.role=='anchor': return self._gather()
        if self.role=='leader': return self._lead()
        if self.role in('centre','leave'): return self._keep()
        if self.role=='join': return 0j
        return self._file()
    def _respected(self):
        for n in {self.left,self.right}|self.old:
            if n>0 and n in self.known: yield self.known[n], self._side_of(n)
    def _ok(self,way,barrier=True,wall_m=0.13):
        at=self.here+way
        if barrier:
            for p,side in self._respected():
                if self.tick-p.tick>2: return False
                m=self._link(p,side,at)
                if m<self.step_m:
                    now=self._margins.get(p.number)
                    if now is None: now=self._margins[p.number]=self._link(p,side)
                    if m<now-1e-6 : return False
        if len(self.hits):
            d=np.abs(self.hits-at).min()
            if d<wall_m and d<np.abs(self.hits-self.here).min()-1e-9: return False
        for p in self.known.values():
            d=abs(p.here-at)
            if d<self.body+0.03 and d<abs(p.here-self.here): return False
        return True
    def _best(self,way,**k):
        """The nearest allowed way to the wanted one."""
        if abs(way)<1e-6: return 0j
        way=shortened(way,self.step_m)
        for size in(1.,.5):
            for turn in(0,30,-30,60,-60,85,-85):
                w=way*size*cmath.rect(1,math.radians(turn))*(1 if turn==0 else math.cos(math.radians(turn)))
                if abs(w)>0.004 and self._ok(w,**k): return w
        return 0j
    def _lead(self):
        hand='left' if self.left==WALL else 'right'
        # keep track of the contact
        if len(self.hits):
            near=self.hits[np.abs(self.hits-self.contact)<=0.15]
            c=nearest(near,self.here)
            self.contact=c if c is not None else nearest(self.hits,self.here)
        bodies=np.array([p.here for p in self.known.values() if p.beacon.role in('file','free') and abs(p.here-self.here)<0.36],dtype=complex)
        keep=max(self.parameters.obstacle_m,min(abs(self.contact-self.here)-0.3*self.step_m,0.45))
        way,contact=roll(self.here,np.concatenate((self.hits,bodies)),self.contact,hand,keep,self.step_m)
        u=self.rw if hand=='left' else self.lw
        a=turn_rad(u,way,hand) if abs(u)>1e-9 else 0.
        self.angle=0. if a>1.8*math.pi else a
        if self.halted(): return 0j
        if self.order in(-1,-2): return self._retreat(hand)
        if self.order!=0 or self.close: return 0j
        other=(self.in_right if hand=='left' else self.in_left)
        if other is None: return 0j
        shorten=self.angle<math.pi/2-0.02
        if not shorten and (self.any_pinned() or not self.is_main() or self.angle>other.angle_rad+0.01): return 0j
        sign=-1 if hand=='left' else 1
        for turn in (0,20,40,60,80,100):
            w=way*cmath.rect(1,sign*math.radians(turn))
            for f in(1.,.5,.2):
                if self._ok(w*f,wall_m=0.1):
                    if f==1. and turn==0: self.contact=contact
                    return w*f
        return 0j
    def _retreat(self,hand):
        other=(self.in_right if hand=='left' else self.in_left)
        if other is None or self.angle<=math.pi/2 or self.angle<other.angle_rad-0.3: return 0j
        back='right' if hand=='left' else 'left'
        keep=max(self.parameters.obstacle_m,min(abs(self.contact-self.here)-0.3*self.step_m,0.45))
        way,contact=roll(self.here,self.hits,self.contact,back,keep,self.step_m)
        for f in(1.,.5):
            if self._ok(way*f,wall_m=0.1):
                if f==1.: self.contact=contact
                return way*f
        return 0j
    def _push(self,a,b):
        """Forward as far as both links reach."""
        n=1j*unit(b.here-a.here)
        for turn in(0,25,-25,50,-50):
            w=n*self.step_m*cmath.rect(1,math.radians(turn))
            for p,side in((a,'left'),(b,'right')):
                if abs(p.here-self.here-w)>self.parameters.follow_m+0.05: break
            else:
                if self._ok(w): return w
        if self.tick-self.pushed>12: self.taut=self.place
        return 0j
    def _keep(self):
        a,b=self.peer(self.left),self.peer(self.right)
        if not a or not b or self.pinned or self.halted() or self.ready: return 0j
        f=self.parameters.follow_m
        if self.order>0 and self.order==self.place and self.role=='centre':
            w=self._push(a,b)
            if w: self.pushed=self.tick
            return w
        wanted=self._wants() or any(f.want for f in(self.in_left,self.in_right) if f)
        if self.order==0 and not wanted and self.role=='centre' and a.beacon.role!='leave' and b.beacon.role!='leave' and not self.old:
            d=abs(a.here-b.here)
            if d<=f-0.1 and a.beacon.right==self.me and b.beacon.left==self.me and not b.beacon.close and not a.beacon.pinned and not a.beacon.close and self._margin(a.here,b.here,np.concatenate((self._walls(a),b.hits(self.eye))))>=self.step_m:
                self.role='leave'; self.wait=self.tick
        pivot=a if a.beacon.pinned else b if b.beacon.pinned else None
        if pivot and not self.ready:
            w=pivot.here+pivot.turn*pivot.beacon.wall
            if abs(w-self.here)>0.35:
                way=self._best(w-self.here)
                if way: return way
        space=0.25 if a.beacon.pinned or a.beacon.close else f
        A,B=a.here,b.here
        A=self._via(A,self.here,self._walls(a),A); B=self._via(self.here,B,self._walls(b),B)
        used=abs(A-a.here); length=abs(B-A)
        arc=space-used
        most=length-(0.34 if B==b.here else 0.)
        if b.beacon.close and b.beacon.role=='leader': arc=max(arc,min(most-0.05,1.1))
        arc=min(max(arc,0.),max(most,0.))
        if A==a.here: arc=max(arc,min(0.25,length/2))
        target=A+(B-A)*(arc/length) if length>1e-9 else self.here
        way=target-self.here
        if abs(way)<0.025: return 0j
        if abs(target-self.aim)>0.05: self.aim=target; self.nearest_m=abs(way); self.nearer=self.tick
        elif abs(way)<self.nearest_m-0.01: self.nearest_m=abs(way); self.nearer=self.tick
        elif self.tick-self.nearer>10: return 0j
        return self._best(way)
    def _via(self,a,b,walls,end):
        """The point the taut link goes through next to `end`; `end` if it is straight."""
        d=abs(b-a)
        if d<1e-9: return end
        n=1j*(b-a)/d; mid=(a+b)/2
        for k in range(7):
            via=mid+n*0.08*k
            if min(clearance_m(walls,a,via),clearance_m(walls,via,b))>=0.06+self.step_m: return end if k==0 else via
        return end
    # ------------------------------------------------------------- forming
    def _form(self):
        for p in self.known.values():
            if p.beacon.role=='leader' and p.beacon.right==self.me:
                return self._second(p)
            if p.beacon.role=='leader' and p.beacon.left==WALL and p.beacon.right>0 and self.peer(p.beacon.right) and self.peer(p.beacon.right).beacon.left==p.number:
                self._to_file(); return 0j
        if self.tick-self.born<6: return 0j
        def wall(r): 
            r=r[np.isfinite(r)]; return round(float(r.min()),2) if len(r) else 9.
        mine=(wall(self.ranges),self.me)
        for p in self.known.values():
            p.hits(self.eye)
            if p.beacon.role=='leader' or (wall(p.ranges_m),p.number)<mine: return 0j
        if mine[0]>self.parameters.obstacle_m+0.02:
            c=nearest(self.hits,self.here)
            return shortened(c-self.here,self.step_m) if c is not None else 0j
        # anchor
        self.contact=nearest(self.hits,self.here); out=unit(self.here-self.contact); spot=self.here-1j*out*0.3
        b=min(self.known.values(),key=lambda p:abs(p.here-spot))
        self.role='leader'; self.left=WALL; self.right=b.number; self.stage='form'; self.wait=self.tick; self.line=0; self.since=self.tick
        return 0j
    def _retry(self):
        near=[p for p in self.known.values() if p.beacon.role in('file','free') and p.beacon.epoch==self.epoch and p.number!=self.right]
        if near: self.right=near[(self.tick//150)%len(near)].number
        self.wait=self.tick
    def _second(self,p):
        w=p.here+p.turn*p.beacon.wall; out=unit(p.here-w); spot=p.here-1j*out*0.3
        c=nearest(self.hits,self.here)
        if c is not None and abs(c-self.here)<0.4 and abs(p.here-self.here)<0.55 and ((self.here-p.here)/(-1j*out)).real>0.1:
            self.role='leader'; self.left=p.number; self.right=WALL; self.contact=c; self.moved=self.tick; self.line=0; self.since=p.beacon.since
            self.graph.begin(2)
            return 0j
        return self._best(spot-self.here,barrier=False)
    def _gather(self):
        """The anchor walks on along its wall to a corner, waits for everybody, and forms a line with one of them."""
        n=self.parameters.team-len(self.dead)
        here=1+self._spare()
        if self.stage=='gather' and self.restarts>1 and self.walked<12.:
            before=self.contact-self.here
            way=self._travel_on()
            self.walked+=abs(way)
            if way: self.turns=(self.turns+[unit(way)])[-24:]
            if self.walked>4. and len(self.turns)==24 and turn_rad(self.turns[0],self.turns[-1],'right')<math.pi and turn_rad(self.turns[0],self.turns[-1],'right')>1.0: self.walked=99.
            return way
        c=nearest(self.hits,self.here)
        if c is None:
            others=[p.hits(self.eye) for p in self.known.values()]
            c=nearest(np.concatenate(others),self.here) if others else None
            return self._best((c-self.here) if c is not None else self.step_m+0j,barrier=False)
        self.contact=c
        waited=self.tick-self.gathered
        if here<n and waited<self.parameters.patience or here<2: return 0j
        if abs(c-self.here)>self.parameters.obstacle_m+0.02: return self._best(c-self.here,barrier=False,wall_m=0.1)
        out=unit(self.here-c); spot=self.here-1j*out*0.3
        near=[p for p in self.known.values() if p.beacon.role in('file','free') and p.beacon.epoch==self.epoch and abs(p.here-self.here)<1.2]
        if not near: return 0j
        b=min(near,key=lambda p:abs(p.here-spot))
        self.role='leader'; self.left=WALL; self.right=b.number; self.stage='form'; self.wait=self.tick; self.line=0; self.since=self.tick
        return 0j
    # ------------------------------------------------------------- file
    def _file(self):
        for p in self.known.values():
            if p.beacon.role=='leader' and p.beacon.stage=='form' and p.beacon.right==self.me and p.beacon.epoch==self.epoch and self.graph.main is None:
                return self._second(p)
        push=0j
        for p in self.known.values():
            if p.beacon.role:
                v=self.here-p.here
                r=0.4 if p.beacon.role=='leader' else 0.28 if p.beacon.role!='file' else 0.26
                if abs(v)<r: push+=unit(v)*(r+.02-abs(v))
        if self.role=='file' and push:
            way=self._best(unit(push)*self.step_m,barrier=False)
            if way: return way
        if self.courier==self.me and self.epoch:
            self.ahead=0; self.rank=9999
            return self._travel()
        main=self.graph.main
        self.tail=min(50,1+self._spare())
        def mine(p): return p.beacon.epoch==self.epoch and (p.beacon.role=='anchor' and self.courier!=self.me or p.beacon.role in('leader','centre') and main is not None and p.beacon.line==main.line)
        taken={p.beacon.ahead:p for p in self.known.values() if p.beacon.role=='file' and p.beacon.ahead}
        def free(p):
            if mine(p): return True
            t=taken.get(p.number); return t is None or (t.number>self.me and self.ahead==p.number)
        cand=[]
        for p in self.known.values():
            d=abs(p.here-self.here)
            if mine(p) and (d<0.6 or clearance_m(np.concatenate((self.hits,p.hits(self.eye))),self.here,p.here)>=0.13): cand.append((0,d,p))
            elif p.beacon.role=='file' and p.beacon.rank<9000 and p.beacon.ahead!=self.me and d<1.2: cand.append((p.beacon.rank,d,p))
        cur=self.peer(self.ahead) if self.ahead else None
        near=[c for c in cand if c[0]==0 and c[1]<0.6]
        bad=cur is None or not (mine(cur) or cur.beacon.role=='file') or not free(cur) or (cur.beacon.role=='file' and cur.beacon.rank>=min(self.rank,9000)) or abs(cur.here-self.here)>1.9
        if bad or (near and self.rank>1) or (mine(cur) and near and min(c[1] for c in near)+0.2<abs(cur.here-self.here)):
            ok=[c for c in cand if free(c[2]) and (c[0]<self.rank or self.rank>=9000)]
            cur=min(ok,key=lambda c:(c[0]>0,c[1],c[0]))[2] if ok else (None if bad else cur)
            self.crumbs=[]
        self.ahead=cur.number if cur else 0
        self.rank=(0 if mine(cur) else cur.beacon.rank)+1 if cur else 9999
        if cur is None:
            return self._travel()
        # insertion
        if mine(cur) and self.role=='file':
            b=cur.beacon; want=any(f.want for f in (b.from_left,b.from_right) if f)
            count=(b.from_left.count+b.from_right.count-1) if b.from_left and b.from_right else 0
            if (want,count,cur.number)!=self.wanted[:3]: self.wanted=(want,count,cur.number,self.tick)
            eager=[p for p in self.known.values() if p.beacon.role=='join' or p.beacon.role=='file' and p.beacon.ahead and self.peer(p.beacon.ahead) and mine(self.peer(p.beacon.ahead)) and p.number<self.me]
            if want and count and self.tick-self.wanted[3]>3+(2*count if eager else 0):
                mids=[]
                for n,side in((b.right,'right'),(b.left,'left')):
                    c=self.peer(n) if n>0 else None
                    if c is None or c.beacon.role not in('leader','centre'): continue
                    l,r=(cur,c) if side=='right' else (c,cur)
                    if l.beacon.right!=r.number or r.beacon.left!=l.number or l.beacon.pinned or l.beacon.ready or r.beacon.ready: continue
                    if self._link(l,'left')>=0.02 and self._link(r,'right')>=0.02:
                        self.role='join'; self.left,self.right=l.number,r.number; self.wait=self.tick; self.old=set(); self.moved=self.tick
                        return 0j
                    mids.append((l.here+r.here)/2)
                if mids:
                    mid=min(mids,key=lambda m:abs(m-self.here))
                    way=self._best(mid-self.here,barrier=False)
                    if way: return way
        if not self.crumbs or abs(self.crumbs[-1]-cur.here)>0.04: self.crumbs.append(cur.here)
        d=abs(cur.here-self.here)
        if d<=(0.5 if cur.beacon.role=='leader' else 0.36):
            self.crumbs=self.crumbs[-1:]
            if d<0.26: return self._best(unit(self.here-cur.here)*0.03,barrier=False)
            return 0j
        goal=self.crumbs[0]
        for k in range(len(self.crumbs)-1,-1,-1):
            if abs(self.crumbs[k]-self.here)<=0.6 and clearance_m(self.hits,self.here,self.crumbs[k])>=0.12:
                goal=self.crumbs[k]; self.crumbs=self.crumbs[k:]; break
        if abs(goal-self.here)<0.05 and len(self.crumbs)>1: self.crumbs.pop(0)
        return self._best(goal-self.here,barrier=False)
    def _lines_seen(self):
        """Lines of robots as walls: places along their links, and from leaders to their walls."""
        out=[]
        for p in self.known.values():
            if p.beacon.role not in('leader','centre','leave'): continue
            ends=[p.beacon.right] if p.beacon.right>0 else []
            for n in ends:
                q=self.peer(n)
                if q: out.append(p.here+np.linspace(0,1,12)*(q.here-p.here))
            if p.beacon.role=='leader': out.append(p.here+np.linspace(0,1,5)*p.turn*p.beacon.wall)
        return np.concatenate(out) if out else NOTHING
    def _travel(self):
        if self.courier==self.me and self.epoch:
            a=self.peer(self.anchor)
            if a is None: self.left_anchor=True
            elif self.left_anchor: self.courier=0
        elif self.graph.main is None and not self.graph.lines() and not self.anchor: return 0j
        return self._travel_on()
    def _travel_on(self):
        walls=np.concatenate((self.hits,self._lines_seen()))
        if not len(walls): 
            return shortened(self.contact-self.here,self.step_m)
        near=walls[np.abs(walls-self.contact)<=0.2]
        c=nearest(near,self.here)
        self.contact=c if c is not None else nearest(walls,self.here)
        keep=max(0.2,min(abs(self.contact-self.here)-0.3*self.step_m,0.45))
        way,contact=roll(self.here,walls,self.contact,self.hand,keep,self.step_m)
        for f in(1.,.5):
            if self._ok(way*f,barrier=False,wall_m=0.1):
                if f==1.: self.contact=contact
                return way*f
        return self._best(way,barrier=False)
